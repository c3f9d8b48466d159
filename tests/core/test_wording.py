"""Options are named as the reader writes them."""

from tracer.core.wording import option, speaking_to_command_line


def test_an_option_is_written_as_its_reader_does():
    assert option("overwrite") == "overwrite=True"
    assert option("checkpoint_every", "4") == "checkpoint_every=4"
    with speaking_to_command_line():
        assert option("overwrite") == "--overwrite"
        assert option("checkpoint_every", "4") == "--checkpoint-every 4"
    assert option("overwrite") == "overwrite=True"
