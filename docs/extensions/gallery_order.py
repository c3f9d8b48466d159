"""The order in which the gallery shows the examples: what most people want first."""

from typing import ClassVar

from sphinx_gallery.sorting import FileNameSortKey


class Order(FileNameSortKey):
    """Give each example its place; examples that are not named here come last."""

    first: ClassVar[list[str]] = ["render_and_compare", "until_the_noise_is_low", "plain_mitsuba", "many_lights"]

    def __call__(self, filename: str) -> tuple[int, str]:
        """Return what examples are sorted by."""
        name = filename.removesuffix(".py")
        return self.first.index(name) if name in self.first else len(self.first), name
