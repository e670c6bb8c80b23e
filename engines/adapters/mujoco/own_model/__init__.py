"""A user's own MuJoCo model as an audit needs it: read, checked, as a continuous motion, and
stepped."""
