"""Template of a body on one hinge: its joint, whether its geom collides, other elements."""

HINGE = """
<mujoco>
  <worldbody>
    <body>
      <joint type="hinge" axis="1 0 0" {joint}/>
      <geom size=".1" pos="0 0 -1" contype="{contype}" conaffinity="0"/>
    </body>
    <geom type="plane" size="5 5 .1" pos="0 0 -9" contype="0" conaffinity="0"/>
  </worldbody>
  {more}
</mujoco>
"""
