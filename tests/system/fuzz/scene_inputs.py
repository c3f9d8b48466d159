"""Broken scene files: bytes, text, elements and values."""

import re
import xml.etree.ElementTree as Tree

from .scenery import SCENES, words, xml

VALUES = (
    *words(
        "nan -nan inf -inf 1e39 -1e39 1e-45 1e400 0 -0 -1 -3 1 2 0.5 0,0,0 1,2 1,2,3,4 nan,nan,nan -1,-2,-3 inf,0,0 "
        "2147483647 2147483648 4294967296 -2147483649 99999999999999999999 0x10 1_0 true false TRUE yes None ball lamp "
        "path $x $ / . .. ~ * %s%n 400:1,700:2 700:1,400:2 400:nan,500:1"
    ),
    *["", " ", "  1  ", "1 2 3 4", "ä€😀", "a" * 5000, "1," * 400 + "1", "\t\n", "../../etc/passwd", "/dev/null"],
)
NUMBERS = words("nan inf -inf 1e30 -1e30 1e-30 0 -0 -1 -3 1 2 5 7 0.1 0.5 0.99 1.5 90 180")
"""Most of which can be read as a value of most kinds."""
TAGS = words(
    "scene shape bsdf emitter sensor film sampler rfilter integrator medium phase texture volume spectrum rgb float "
    "integer string boolean point vector transform matrix translate rotate scale lookat ref include alias default path "
    "resources nonsense"
)
TYPES = words(
    "sphere rectangle cube disk cylinder obj ply serialized instance shapegroup merge sdfgrid bsplinecurve diffuse "
    "dielectric conductor null mask measured constant area envmap point spot directional sunsky projector perspective "
    "thinlens orthographic radiancemeter irradiancemeter distant batch hdrfilm specfilm independent stratified "
    "owen_sobol box gaussian lanczos path direct ptracer adaptive radiosity aov moment stokes prb depth isotropic hg "
    "homogeneous heterogeneous gridvolume constvolume bitmap checkerboard mesh_attribute d65 regular blackbody nothing"
)


def render(folder, text, *options, name="scene.xml"):
    """Write a scene and return how it is rendered."""
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return ["render", str(path), "-o", str(folder.parent / "out" / "out.exr"), "--spp", "1", "-q", *options]


def some_scene(random):
    return xml(SCENES[random.choice(list(SCENES))])


def small(random):
    """Return options that give the picture a size of its own; mostly, as the scene's may then be absurd."""
    return [] if random.random() < 0.1 else ["--size", "6"]


def cut_short(random, folder):
    text = some_scene(random)
    return render(folder, text[: random.randrange(len(text))], *small(random))


def flipped_bytes(random, folder):
    data = bytearray(some_scene(random).encode())
    for _ in range(random.choice([1, 1, 2, 5, 40])):
        place = random.randrange(len(data))
        data[place] = random.choice([random.randrange(256), data[place] ^ (1 << random.randrange(8)), 0])
    return render(folder, bytes(data), *small(random))


def moved_text(random, folder):
    """Delete, repeat or move a piece of text."""
    text = some_scene(random)
    begin = random.randrange(len(text))
    piece = text[begin : begin + random.choice([1, 3, 20, 100, 400])]
    rest = text.replace(piece, "", 1) if random.random() < 0.6 else text
    place = random.randrange(len(rest) + 1)
    return render(folder, rest[:place] + piece * random.choice([0, 1, 1, 2]) + rest[place:], *small(random))


def changed_elements(random, folder):
    root = Tree.fromstring(some_scene(random))
    for _ in range(random.choice([1, 1, 1, 2, 3])):
        parents = [parent for parent in root.iter() if len(parent)]
        parent = random.choice(parents or [root])
        child = random.choice(list(parent) or [Tree.Element("scene")])
        change_element(random, root, parent, child)
    return render(folder, Tree.tostring(root), *small(random))


def copy(element):
    """Return a copy: an element within itself has no end."""
    return Tree.fromstring(Tree.tostring(element))


def change_element(random, root, parent, child):
    """Delete, repeat, rename, retype or nest an element, or change its attributes."""
    what = random.choice(["delete", "repeat", "rename", "retype", "nest", "move", "lose", "gain", "swap", "name"])
    if what == "delete" and child in list(parent):
        parent.remove(child)
    elif what == "repeat":
        parent.append(copy(child))
    elif what == "rename":
        child.tag = random.choice(TAGS)
    elif what == "retype":
        child.set("type", random.choice(TYPES))
    elif what == "nest":
        child.append(copy(random.choice(list(root.iter()))))
    elif what == "move":
        random.choice(list(root) or [root]).append(copy(child))
    elif what == "lose" and child.attrib:
        del child.attrib[random.choice(list(child.attrib))]
    elif what == "gain":
        child.set(random.choice(["id", "name", "type", "value", "x", "version", "filename"]), random.choice(VALUES))
    elif what == "swap":
        parent[:] = random.sample(list(parent), len(parent))
    elif what == "name":
        child.set("name", random.choice(["to_world", "radiance", "filename", "radius", "nothing", "", "_x", "emitter"]))


def changed_values(random, folder, scene=None):
    root = Tree.fromstring(scene or some_scene(random))
    for _ in range(random.choice([1, 1, 1, 2, 4])):
        elements = [one for one in root.iter() if {*one.attrib} - {"type", "id", "name", "version"}]
        element = random.choice(elements)
        name = random.choice([name for name in element.attrib if name not in ("type", "id", "name", "version")])
        element.set(name, random.choice(NUMBERS if random.random() < 0.6 else VALUES))
    return render(folder, clean(Tree.tostring(root)), *small(random))


def clean(text):
    """Return XML without what is said of the machine: the largest numbers are kept for the kind ``films``."""
    return re.sub(rb'(name="(?:width|height)" value=")(?:2147483647)"', rb'\1-7"', text)
