"""Scene files whose parts refer to nothing or to themselves, that are no scenes, or whose film is absurd."""

from .scene_inputs import TYPES, changed_elements, changed_values, cut_short, render, small
from .scenery import FILM as PLAIN_FILM
from .scenery import SCENES, words, xml

DEEPEST = 3000
REFERENCES = (
    '<ref id="nothing"/>',
    '<shape type="sphere"><ref id="nothing"/></shape>',
    '<bsdf type="twosided" id="a"><ref id="a"/></bsdf><shape type="sphere"><ref id="a"/></shape>',
    '<bsdf type="twosided" id="a"><ref id="b"/></bsdf><bsdf type="twosided" id="b"><ref id="a"/></bsdf>'
    '<shape type="sphere"><ref id="a"/></shape>',
    '<shape type="shapegroup" id="g"><shape type="instance"><ref id="g"/></shape></shape>'
    '<shape type="instance"><ref id="g"/></shape>',
    '<shape type="shapegroup" id="g"/><shape type="instance"><ref id="g"/></shape>',
    '<shape type="instance"/>',
    '<shape type="instance"><ref id="grey"/></shape>',
    '<shape type="sphere" id="x"/><shape type="sphere" id="x"/>',
    '<shape type="sphere"><ref id="x" name="bsdf"/></shape><emitter type="constant" id="x"/>',
    '<alias id="grey" as="grey"/>',
    '<alias id="nothing" as="other"/>',
    '<include filename="scene.xml"/>',
    '<include filename="nothing.xml"/>',
    '<include filename="."/>',
    '<include filename=""/>',
    '<include filename="/dev/null"/>',
    '<default name="x" value="$x"/><float name="y" value="$x"/>',
    '<default name="x" value="1"/><shape type="sphere"><float name="radius" value="$x$x"/></shape>',
    '<shape type="sphere"><float name="radius" value="$undefined"/></shape>',
    '<path value="nowhere"/>',
    '<resources path="nowhere"/>',
    '<shape type="merge"/>',
    '<shape type="merge"><shape type="sphere"/></shape>',
    '<sensor type="batch"/>',
    '<emitter type="area"/>',
    '<texture type="bitmap" id="t"/>',
    '<bsdf type="normalmap"><bsdf type="diffuse"/></bsdf>',
    '<bsdf type="bumpmap"/>',
    '<medium type="heterogeneous"/>',
    '<volume type="gridvolume"><string name="filename" value="scene.xml"/></volume>',
    '<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>',
    '<?xml version="1.0"?><scene version="0.1.0"/>',
    "<!-- ",
    "<![CDATA[ ]]>",
)


def references(random, folder):
    """References to nothing, to themselves, and in circles; parts that lack what they need."""
    extra = "".join(random.sample(REFERENCES, random.choice([1, 1, 2])))
    body = SCENES[random.choice(["plain", "lamp"])]
    return render(folder, xml(extra + body if random.random() < 0.3 else body + extra), *small(random))


def nothing_much(random, folder):
    """Files that are no scenes at all."""
    depth = random.choice([10, 300, DEEPEST])
    text = random.choice(
        [
            "",
            "\0" * 100,
            "\ufeff" + xml(SCENES["plain"]),
            xml(SCENES["plain"]).encode("utf-16"),
            xml(""),
            "<scene/>",
            '<scene version="9.9.9"/>',
            '<scene version="a.b"/>',
            '<shape version="3.0.0" type="sphere"/>',
            '<shape version="3.0.0"/>',
            f'<bsdf version="3.0.0" type="{random.choice(TYPES)}"/>',
            '<scene version="3.0.0">' + '<bsdf type="twosided">' * depth + "</bsdf>" * depth + "</scene>",
            "<a>" * depth,
            bytes(random.randrange(256) for _ in range(random.randrange(2000))),
            xml(SCENES["plain"]) * 2,
            "{" + '"type": "scene"' + "}",
        ]
    )
    return render(folder, text, *small(random))


FILM_VALUES = (*words("0 -1 1 2 3 7 9 50000 2147483647 4294967295 1e9 8.5 nan x"), *[""])
FILM = (
    '<film type="hdrfilm"><integer name="width" value="{0}"/><integer name="height" value="{1}"/>'
    '<integer name="crop_offset_x" value="{2}"/><integer name="crop_width" value="{3}"/>'
    '<string name="pixel_format" value="{4}"/><string name="component_format" value="{5}"/>'
    '<boolean name="sample_border" value="{6}"/><rfilter type="{7}"/></film>'
)


def films(random, folder):
    """Films of absurd sizes, crop windows and formats."""
    sizes = ["8", "6", "0", "8"]
    for _ in range(random.choice([0, 1, 1, 2])):
        sizes[random.randrange(4)] = random.choice(FILM_VALUES)
    words = [
        random.choice(["rgb", "rgba", "luminance", "luminance_alpha", "xyz", "xyza", "RGB", "nothing", ""]),
        random.choice(["float16", "float32", "uint32", "float32", "int8"]),
        random.choice(["true", "false", "1"]),
        random.choice(["box", "gaussian", "box", "nothing"]),
    ]
    text = xml(SCENES["plain"].replace(PLAIN_FILM.format(filter="box"), FILM.format(*sizes, *words)))
    return render(folder, text, *([] if random.random() < 0.6 else ["--size", "6"]))


def radiosity(random, folder):
    """The same to be solved for radiosity, with options of every kind."""
    if random.random() < 0.3:
        arguments = random.choice([cut_short, changed_elements])(random, folder)
    else:
        arguments = changed_values(random, folder, xml(SCENES["radiosity"]))
    options = ["--method", random.choice(["gathering", "shooting"]), "--show", random.choice(["gather", "smooth"])]
    if random.random() < 0.3:
        name = random.choice(["--patch", "--rays", "--residual", "--method", "--show"])
        options += [name, random.choice(["0", "-1", "1", "2", "0.5", "9", "nan", "inf", "1e-30", "1e30", "patches"])]
    coarse = [] if "--patch" in options else ["--patch", "2"]
    quick = [] if "--rays" in options else ["--rays", "16"]
    return ["radiosity", *arguments[1:], *coarse, *quick, *options]
