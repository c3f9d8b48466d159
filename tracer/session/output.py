"""Write the picture of a request, with the metadata by which it can be made again."""

from __future__ import annotations

from tracer.errors import WriteError
from tracer.result import Result, metadata, renamed_layers, write_result
from tracer.session.keeper import Keeper
from tracer.session.request import PictureFile


def write_picture(file: PictureFile, result: Result, scene_hash: str, keeper: Keeper | None) -> None:
    """Write the picture of a request. Raises WriteError, which says where its samples are if ``keeper`` has them."""
    if file.path.suffix.lower() == ".exr" and file.layers == "all" and (renamed := renamed_layers(result)):
        result.report.note(f"Layers of tracer have the names of AOVs, which are written as {', '.join(renamed)}.")
    try:
        origin = {"job": file.origin} if file.origin else {}
        write_result(file.path, result, metadata(result, scene_hash) | origin, file.layers)
    except WriteError as error:
        where_samples_are = keeper.all_is_kept() if keeper is not None else ""
        raise WriteError(f"{error} {where_samples_are}".rstrip()) from None
