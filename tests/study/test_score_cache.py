"""Scores that are kept belong to the pixels of a picture and its reference, whichever cell they come from."""

from types import SimpleNamespace

import numpy as np

from tracer.image import metrics
from tracer.study.score_cache import ScoreBook


def test_scores_are_of_the_pixels(tmp_path, monkeypatch):
    generator = np.random.default_rng(3)
    pictures = generator.random((2, 16, 16, 3), np.float32)
    references = [SimpleNamespace(image=image) for image in generator.random((2, 16, 16, 3))]
    computed = []
    all_scores = metrics.all_scores

    def counted(image, reference):
        computed.append(image)
        return all_scores(image, reference)

    monkeypatch.setattr(metrics, "all_scores", counted)
    for _ in range(2):  # the second book reads the file of the first
        book = ScoreBook(tmp_path / "scores.json")
        for picture in pictures:
            for reference in references:
                assert book.scores(picture, reference).mse == metrics.mse(picture, reference.image)
        book.save()
    assert len(computed) == 4


def test_a_damaged_file_is_replaced(tmp_path):
    path = tmp_path / "scores.json"
    path.write_text('{"half')
    ScoreBook(path).save()
    assert path.read_text() == "{}"
