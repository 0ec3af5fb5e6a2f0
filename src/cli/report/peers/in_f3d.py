"""Shows a CAD file with F3D: FILE WIDTH HEIGHT FRAMES. Prints milliseconds."""

import sys
import time

import f3d

path, width, height, frames = sys.argv[1], *map(int, sys.argv[2:])


def milliseconds(task):
    start = time.perf_counter()
    task()
    return 1e3 * (time.perf_counter() - start)


f3d.Log.set_verbose_level(f3d.Log.QUIET)
f3d.Engine.autoload_plugins()
engine = None
for create in (f3d.Engine.create_egl, f3d.Engine.create_osmesa):
    try:
        engine = create()
        break
    except Exception:
        pass
if engine is None:
    sys.exit("it gets no context by EGL or OSMesa")
engine.options.update({"scene.up_direction": "+Z"})
window = engine.window
window.size = width, height
print("load", milliseconds(lambda: engine.scene.add(path)))
# From the front and above, as the isometric view of `freeform`.
camera = window.camera
camera.azimuth(45)
camera.elevation(35.264)
camera.reset_to_bounds()
print("first", milliseconds(window.render))
times = []
for number in range(frames):
    camera.azimuth(0.125 if number % 16 < 8 else -0.125)
    times.append(milliseconds(window.render))
print("frame", sorted(times)[len(times) // 2])
