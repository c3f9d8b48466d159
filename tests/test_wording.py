"""Options are named as the reader writes them."""

from tracer.wording import option, speaking_to_command_line


def test_an_option_is_written_as_its_reader_does():
    assert option("overwrite") == "overwrite=True"
    assert option("memory_limit", "4") == "memory_limit=4"
    with speaking_to_command_line():
        assert option("overwrite") == "--overwrite"
        assert option("memory_limit", "4") == "--memory-limit 4"
    assert option("overwrite") == "overwrite=True"
