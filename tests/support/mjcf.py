"""Small MJCFs made by hand, each about one subject."""

ARM = """<mujoco model="arm">
  <compiler angle="degree"/>
  <option gravity="0 0 -3"/>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="trunk" pos="0 0 1">
      <freejoint name="root"/>
      <geom type="box" size=".2 .1 .1"/>
      <body name="upper" pos=".2 0 0" euler="10 20 30">
        <joint name="shoulder" pos="0 0 .1" axis="1 1 0" range="-30 60" damping="1"/>
        <joint name="slide" type="slide" axis="0 1 0" pos=".1 0 0" ref=".1" springref=".3"
               stiffness="5"/>
        <geom type="capsule" fromto="0 0 0 .5 0 0" size=".03"/>
        <body name="lower" pos=".5 0 0">
          <joint name="wrist" type="ball" pos="0 .02 0"/>
          <geom type="cylinder" fromto="0 0 0 0 .4 0" size=".03"/>
          <site name="tip" pos="0 .4 0" euler="0 90 0"/>
        </body>
      </body>
    </body>
  </worldbody>
  <sensor><gyro name="turn" site="tip"/><accelerometer site="tip"/></sensor>
</mujoco>
"""


def with_parts(joints: str = "", after: str = "", option: str = "") -> str:
    """Two links in a row, each with a hinge, and what a test adds."""
    return f"""<mujoco model="pair">
  <compiler angle="radian"/>
  {option}
  <worldbody>
    <body name="a">
      <joint name="one" axis="0 1 0"/>
      {joints}
      <geom name="ga" type="box" size=".1 .05 .03" pos=".2 0 0" mass="2"/>
      <body name="b" pos=".5 0 0">
        <joint name="two" axis="0 1 0"/>
        <geom name="gb" type="box" size=".1 .02 .03" pos=".3 0 0" mass="1"/>
        <site name="end" pos=".6 0 0"/>
      </body>
    </body>
  </worldbody>
  {after}
</mujoco>
"""
