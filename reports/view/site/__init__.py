"""The site: an index, a page a system and a page a scene, which share their files."""
