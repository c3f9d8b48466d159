"""Export every frame of a Blender scene with mitsuba-blender, each into its own folder.

    blender -b shot.blend -P export_frames.py

The exporter gives the meshes of all frames the same names: in one folder, those of the
last frame would replace the others.
"""

import bpy

scene = bpy.context.scene
for frame in range(scene.frame_start, scene.frame_end + 1):
    scene.frame_set(frame)
    path = bpy.path.abspath(f"//exported/{frame:04d}/scene.xml")
    bpy.ops.export_scene.mitsuba(filepath=path, export_ids=True)
