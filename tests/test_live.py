"""A picture that is shown while it renders: in a file, in tev, in a notebook; and what that may cost."""

import socket
import struct
import threading
import time

import numpy as np
import pytest

import tracer
from tracer import live
from tracer.errors import OutputError, SettingsError
from tracer.io.images import read_picture
from tracer.progress import Progress


@pytest.fixture
def at_once(monkeypatch):
    """Show after every pass, and make the passes small."""
    monkeypatch.setattr(live, "LEAST_SECONDS", 0.0)
    monkeypatch.setattr("tracer.sampling.passes.PASS_SIZES", (500, 500, 500))
    monkeypatch.setattr("tracer.session.local_drawer.PASS_SIZES", (500, 500, 500))


def progress(done=10, finished=False):
    image = np.full((4, 6, 3), 0.5, np.float32)
    counts = np.full((4, 6), 3, np.uint32)
    return Progress(done, 20, 1.0, fraction=done / 20, finished=finished, develop=lambda: image, count=lambda: counts)


def test_a_callback_sees_picture_and_counts_as_they_are(cornell, at_once):
    seen = []

    def look(now):
        seen.append((now.done, now.image, now.samples.sum(), now.remaining, now.total))

    result = tracer.render(cornell(), spp=16, progress=look)
    assert len(seen) > 8
    assert [int(drawn) for _, _, drawn, _, _ in seen] == [done for done, *_ in seen]
    assert np.array_equal(seen[-1][1], result.image)
    assert seen[-1][3] == 0
    assert all(total == 16 * 384 for *_, total in seen)


def test_a_png_is_replaced_as_a_whole(cornell, at_once, tmp_path):
    path = tmp_path / "now.png"
    callback = live.png(path)
    sizes = []

    def look(now):
        callback.next = 0.0
        callback(now)
        sizes.append(read_picture(path).shape)

    result = tracer.render(cornell(), spp=8, progress=look)
    assert set(sizes) == {(16, 24, 3)}
    assert callback.shown == len(sizes)
    shown = np.clip(result.image, 0, 1)
    assert abs(read_picture(path) - shown).max() < 0.01
    assert [each.name for each in tmp_path.iterdir()] == ["now.png"]
    with pytest.raises(OutputError):
        live.png(tmp_path / "no" / "now.png")


def test_showing_takes_no_more_than_its_share(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(time, "perf_counter", lambda: clock[0])

    def show(now):
        clock[0] += 0.3

    callback = live.Occasional(show)
    for _ in range(10_000):
        clock[0] += 0.05  # a pass
        callback(progress())
    assert callback.shown > 20
    assert callback.shown * 0.3 < 1.05 * live.SHARE * clock[0] + 0.3


def test_any_callback_can_stop(cornell):
    result = tracer.render(
        cornell(), spp=64, progress=live.together(None, lambda now: None, lambda now: now.done < 4 * 384)
    )
    assert result.report.stopped_by == "person"


def receive(server, packets):
    connection, _ = server.accept()
    with connection:
        stream = connection.makefile("rb")
        while len(head := stream.read(4)) == 4:
            packets.append(stream.read(struct.unpack("<I", head)[0] - 4))


def test_tev_gets_the_picture(at_once):
    with socket.create_server(("127.0.0.1", 0)) as server:
        packets: list[bytes] = []
        listening = threading.Thread(target=receive, args=(server, packets), daemon=True)
        listening.start()
        show = live.tev("a picture", f"127.0.0.1:{server.getsockname()[1]}")
        for _ in range(2):
            show.next = 0.0
            show(progress())
        show.close()
        listening.join(10)
    create, update = 4, 6
    assert [packet[0] for packet in packets] == [create, update, update]
    assert b"a picture" in packets[1]
    values = np.frombuffer(packets[1][-4 * 6 * 4 * 4 :], np.float32)
    assert set(values.tolist()) == {0.5, 3.0}


def test_without_a_viewer_there_is_a_sentence():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with pytest.raises(SettingsError, match="start tev first"):
        live.tev("a picture", f"127.0.0.1:{port}")
    with pytest.raises(SettingsError, match="write host:port"):
        live.tev("a picture", "here:x")


def test_a_notebook_shows_one_display_that_changes(monkeypatch):
    shown = []

    class Handle:
        def update(self, page):
            shown.append(page.data)

    def display(page, display_id):
        shown.append(page.data)
        return Handle()

    monkeypatch.setattr("IPython.display.display", display)
    callback = live.notebook()
    callback.next = 0.0
    callback(progress(10))
    for done in (12, 15, 20):  # all within a second, and none is shown until the end is told
        callback(progress(done))
    callback(progress(20, finished=True))
    assert len(shown) == 2
    assert 'value="0.5000" max="1"' in shown[0]
    assert 'value="1.0000" max="1"' in shown[1]
    assert "data:image/png;base64" in shown[0]


def test_what_stops_being_shown_is_logged(at_once, tmp_path, caplog):
    path = tmp_path / "folder" / "now.png"
    path.parent.mkdir()
    show = live.png(path)
    path.parent.rmdir()
    show(progress())
    show(progress())
    (message,) = [record.getMessage() for record in caplog.records]
    assert str(path) in message
    assert message.endswith("The render goes on without it.")


def test_the_end_is_shown_even_of_a_render_that_takes_no_time(cornell, tmp_path):
    path = tmp_path / "now.png"
    callback = live.png(path)
    result = tracer.render(cornell(), spp=4, progress=callback)
    assert callback.shown == 1
    assert abs(read_picture(path) - np.clip(result.image, 0, 1)).max() < 0.01
