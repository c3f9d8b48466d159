"""Show a picture while it renders: in a PNG, in the viewer tev, in a notebook.

``png``, ``tev`` and ``notebook`` return progress callbacks for ``tracer.render``; ``together`` makes one callback of
many. They show the picture now and then: after a picture that took t seconds the next one waits for at least 50 t, so
that showing takes less than 2 % of the time.

Example::

    import tracer
    from tracer import live


    def stop_after_a_minute(now: tracer.Progress) -> bool:
        return now.seconds < 60


    show = live.together(live.png("now.png"), stop_after_a_minute)
    tracer.render("scene.xml", noise=0.05, progress=show)
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
"""Largest part of the time of a render that may be spent on showing the picture."""
LEAST_SECONDS = 1.0
"""Least seconds between two pictures, and before the first one."""
TEV_PORT = 14158
"""Port on which tev listens by default."""


class Occasional:
    """A progress callback that calls a function with the progress of a render, now and then."""

    def __init__(self, show: Callable[[Progress], None], close: Callable[[], Any] = lambda: None) -> None:
        """``show``: is called with the progress; ``close``: closes what the picture is shown on, such as a viewer."""
        self.show, self.close = show, close
        self.next = time.perf_counter() + LEAST_SECONDS
        self.shown = 0
        self.closed = False
        """Whether what the picture is shown on is gone; nothing is shown any more."""

    def __call__(self, progress: Progress) -> None:
        """Show the progress if it is time to, or if the render is finished."""
        start = time.perf_counter()
        if self.closed or (start < self.next and not progress.finished):
            return
        self.show(progress)
        self.shown += 1
        end = time.perf_counter()
        self.next = end + max(LEAST_SECONDS, (end - start) / SHARE)


def png(path: str | Path) -> ProgressCallback:
    """Return a callback that writes the picture, as a screen shows it, to a PNG file that is replaced as a whole.

    Raises OutputError at once if the file cannot be written. If that happens later, the callback warns and stops
    writing.
    """
    target = Path(path)
    atomic.check_output(target, overwrite=True, suffixes=(".png",))

    def show(progress: Progress) -> None:
        try:
            exr.write_png(target, display(progress.image))
        except OutputError as error:
            callback.closed = True  # a render is not given up for a picture of its progress
            logger.warning("%s The render goes on without it.", error)

    callback = Occasional(show)
    return callback


def tev(name: str, address: str = "") -> ProgressCallback:
    """Return a callback that shows the picture and its sample counts under ``name`` in tev, at ``host:port``.

    ``address``: where tev listens, 127.0.0.1:14158 by default. Raises SettingsError if tevclient is not installed or
    there is no viewer.
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
            callback.closed = True  # a viewer may be closed during the render
            logger.warning("tev does not answer any more (%s). The render goes on without it.", error)

    callback = Occasional(show, lambda: client.__exit__(None, None, None))
    return callback


def notebook() -> ProgressCallback:
    """Return a callback that shows a progress bar and the picture in a Jupyter notebook, and replaces them in place.

    Raises ImportError where IPython, which comes with Jupyter, is not installed.
    """
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
    """Return a progress bar, a line of text and the picture (H, W, C) as HTML."""
    remaining = "" if progress.remaining is None or progress.finished else f", {progress.remaining:.0f} s left"
    return (
        f'<div><progress value="{progress.fraction:.4f}" max="1" style="width:100%"></progress>'
        f"<p>{progress.in_words()}{remaining}</p>"
        f'<img src="data:image/png;base64,{as_png(display(image))}"></div>'
    )


def together(*callbacks: ProgressCallback | None) -> ProgressCallback:
    """Return a callback that calls all ``callbacks``; it stops the render if any of them returns False."""

    def call(progress: Progress) -> bool:
        answers = [callback(progress) for callback in callbacks if callback is not None]
        return not any(answer is False for answer in answers)

    return call
