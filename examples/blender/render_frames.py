"""Render what mitsuba-blender has exported, with adaptive samples.

    python render_frames.py exported frames
    python render_frames.py exported frames --noise 0.05 --denoise

Every ``scene.xml`` in the folder ``exported`` becomes two pictures in the folder
``frames``: an EXR with all layers for the compositor, and a PNG to look at. They are
named after the folder that the scene is in. Size and samples are those of the scene in
Blender unless other ones are asked for. Pictures that are there already are not
rendered again, so that a long job can be stopped and started.
"""

import argparse
from pathlib import Path

import tracer


def render_frames(exported: Path, frames: Path, **settings) -> list[Path]:
    """Render all scenes, and return the files of the pictures."""
    scenes = sorted(exported.rglob("scene.xml"))
    if not scenes:
        raise SystemExit(f"There is no scene.xml in '{exported}'; export one first.")
    frames.mkdir(parents=True, exist_ok=True)
    pictures = [frames / f"{scene.parent.name}.exr" for scene in scenes]
    for scene, picture in zip(scenes, pictures, strict=True):
        if picture.exists():
            continue
        result = tracer.render(scene, **settings)
        result.save(picture.with_suffix(".png"), overwrite=True)
        result.save(picture)
        print(f"{picture}: {str(result.report).splitlines()[0]}")
    return pictures


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("exported", type=Path, help="folder of the exporter")
    parser.add_argument("frames", type=Path, help="folder for the pictures")
    parser.add_argument("--size", type=int, help="width in pixels")
    parser.add_argument("--spp", type=int, help="samples per pixel, on average")
    parser.add_argument(
        "--noise", type=float, help="part of the brightness: 0.05 is 5 %%"
    )
    parser.add_argument("--denoise", action="store_true", help="take the noise out")
    try:
        render_frames(**vars(parser.parse_args()))
    except tracer.errors.TracerError as error:
        raise SystemExit(str(error)) from None
