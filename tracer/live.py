"""Show a picture while it renders: in a PNG, in the viewer tev, in a notebook.

Each is a progress callback for ``tracer.render``; ``together`` makes one of several. They show the picture now and
then: after one that took t seconds the next waits for 50 t at least, so that they take less than 2 % of the time.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.core.version import install_command
from tracer.errors import OutputError, SettingsError
from tracer.image.colour import as_png, display
from tracer.io import atomic, exr
from tracer.progress import Progress, ProgressCallback

logger = logging.getLogger(__name__)

SHARE = 0.02
"""Most of the time that is spent on showing."""
LEAST_SECONDS = 1.0
"""Between two pictures, and before the first."""
TEV_PORT = 14158


class Occasional:
    """Calls a function with the progress of a render, now and then."""

    def __init__(self, show: Callable[[Progress], None], close: Callable[[], Any] = lambda: None) -> None:
        """``close``: gives up what it shows on."""
        self.show, self.close = show, close
        self.next = time.perf_counter() + LEAST_SECONDS
        self.shown = 0
        self.closed = False
        """Whether what it shows on is gone."""

    def __call__(self, progress: Progress) -> None:
        """Show, if it is time, or all is done."""
        start = time.perf_counter()
        if self.closed or (start < self.next and not progress.finished):
            return
        self.show(progress)
        self.shown += 1
        end = time.perf_counter()
        self.next = end + max(LEAST_SECONDS, (end - start) / SHARE)


def png(path: Path) -> Occasional:
    """Return a callback that writes the picture, as a screen shows it, to a PNG that is replaced as a whole.

    Raises OutputError at once if it cannot be written; later it only stops showing.
    """
    atomic.check_output(path, overwrite=True, suffixes=(".png",))

    def show(progress: Progress) -> None:
        try:
            exr.write_png(path, display(progress.image))
        except OutputError as error:
            callback.closed = True  # a picture of progress is not worth the render
            logger.warning("%s The render goes on without it.", error)

    callback = Occasional(show)
    return callback


def tev(name: str, address: str = "") -> Occasional:
    """Return a callback that shows the picture and its sample counts under ``name`` in tev, at ``host:port``.

    Raises SettingsError if tevclient is not installed or there is no viewer.
    """
    host, _, port = (address or "127.0.0.1").partition(":")
    if port and not port.isdecimal():
        raise SettingsError(f"tev: write host:port, with a number (was '{address}').")
    try:
        import tevclient
    except ImportError:
        raise SettingsError(f"tev: tevclient is not installed; install it, {install_command('tev')}.") from None
    client = tevclient.Ipc(host, int(port or TEV_PORT))
    try:
        client.__enter__()
    except OSError as error:
        raise SettingsError(
            f"tev: no viewer answers at {host}:{port or TEV_PORT} ({error}); start tev first."
        ) from None
    channels = ["R", "G", "B", "samples.Y"]
    created: list[str] = []

    def show(progress: Progress) -> None:
        image = progress.image
        colour = image[..., :3] if image.shape[-1] >= 3 else image[..., :1].repeat(3, axis=-1)
        values = np.concatenate([colour, progress.samples[..., None]], axis=-1, dtype=np.float32)
        try:
            if not created:
                client.create_image(name, values.shape[1], values.shape[0], channels)
                created.append(name)
            client.update_image(name, values, channels)
        except OSError as error:
            callback.closed = True  # the viewer, too, may be gone
            logger.warning("tev does not answer any more (%s). The render goes on without it.", error)

    callback = Occasional(show, lambda: client.__exit__(None, None, None))
    return callback


def notebook() -> ProgressCallback:
    """Return a callback that shows bar and picture in a Jupyter notebook, replaced in place."""
    from IPython.display import HTML
    from IPython.display import display as show_html

    handle: list[Any] = []

    def show(progress: Progress) -> None:
        page = HTML(html(progress, progress.image))
        if handle:
            handle[0].update(page)
        else:
            handle.append(show_html(page, display_id=True))

    return Occasional(show)


def html(progress: Progress, image: NDArray) -> str:
    """Return a bar, a line of text and the picture as HTML."""
    left = "" if progress.remaining is None or progress.finished else f", {progress.remaining:.0f} s left"
    return (
        f'<div><progress value="{progress.fraction:.4f}" max="1" style="width:100%"></progress>'
        f"<p>{progress.in_words()}{left}</p>"
        f'<img src="data:image/png;base64,{as_png(display(image))}"></div>'
    )


def together(*callbacks: ProgressCallback | None) -> ProgressCallback:
    """Return a callback that calls all of them; the render stops if any says so."""

    def call(progress: Progress) -> bool:
        answers = [callback(progress) for callback in callbacks if callback is not None]
        return not any(answer is False for answer in answers)

    return call
