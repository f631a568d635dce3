"""
How does an impact travel along a row of balls?
===============================================

Thirty steel balls of 10 mm diameter touch each other and a steel wall.  An equal ball strikes
the first one at 0.1 m/s.  How fast is the pulse, how long is it, and how large is the force on
the wall?
"""

# sphinx_gallery_thumbnail_panel = (1, 0)
import matplotlib.pyplot as plt
import numpy as np

import hertzchain as hc

plt.style.use("hertzchain.figures")

balls = hc.Chain.from_materials(5e-3, "steel-52100", beads=30)
chain = balls.struck_by(velocity=0.1).replace(right_wall=hc.Wall())
chain

# %%
# ``simulate`` integrates the motion of all beads.  Without ``until``, it stops when the peak of
# the force on the wall is complete.  Here it runs longer, so that the reflected pulse can be
# seen.

run = hc.simulate(chain, until=1.2e-3, times=1200)
wall = run.wall_force()
pulse = run.pulse()

# %%
# A map of the force in every contact shows the pulse on its way to the wall and back.  Its
# track is straight: the speed is constant.

figure, (top, bottom) = plt.subplots(2, 1, figsize=(6.4, 7.2), height_ratios=[1.3, 1.0])
run.plot("force", ax=top)
top.set_title("Force in every contact")
for ball in (6, 16, 26):
    bottom.plot(1e6 * run.times, run.force(ball), label=f"contact {ball}")
bottom.plot(wall.times * 1e6, wall.force, color="black", label="wall")
bottom.set_xlim(top.get_xlim())
bottom.set_title("Force over time")
bottom.set_xlabel("time [µs]")
bottom.set_ylabel("force [N]")
bottom.legend()

# %%
# Unlike sound, the pulse is faster if it is stronger: its speed grows with the sixth root of the
# force.  Ten impacts at different velocities show this.

speeds = np.geomspace(0.01, 0.3, 10)
runs = [hc.simulate(balls.struck_by(velocity=speed), check=False) for speed in speeds]
pulse_speed = np.array([each.pulse().speed[20] for each in runs])
force = np.array([each.pulse().peak_force[20] for each in runs])
exponent = np.polyfit(np.log(force), np.log(pulse_speed), 1)[0]

figure, axes = plt.subplots(figsize=(6.4, 4.0))
axes.loglog(force, pulse_speed, "o", label="simulation")
axes.loglog(force, pulse_speed[0] * (force / force[0]) ** (1 / 6), label="sixth root")
axes.set_title("A stronger pulse is faster")
axes.set_xlabel("peak force [N]")
axes.set_ylabel("speed of the pulse [m/s]")
axes.set_yticks([300, 400, 500], ["300", "400", "500"])
axes.minorticks_off()
axes.legend()

# %%
# Answer
# ------

contacts = pulse.peak_force[20]
print(f"speed of the pulse   {pulse.speed[20]:.0f} m/s, growing as force^{exponent:.3f}")
print(f"width at half height {run.pulse_width(16):.2f} ball diameters")
print(f"force in the chain   {contacts:.1f} N")
print(f"force on the wall    {wall.peak:.1f} N, {wall.peak / contacts:.2f} times as large")
