"""Options and configurations with values of the wrong kind, out of range, or against each other."""

from .scene_inputs import render
from .scenery import SCENES, words, xml

OPTIONS = words(
    "--spp --noise --noise-share --time --sensor --size --crop --define --frames --variant --seed --criterion "
    "--objective --exposure --importance --shape-weight --pilot-spp --min-spp --max-spp --cost --block --memory "
    "--integrator --config --checkpoint --checkpoint-every --live --tev"
)
VALUES = (
    *words(
        "nan inf -inf -1 0 1 2 8 0.5 1e9 1e400 4294967296 99999999999999999999 true x all fused uniform display rays "
        "path adaptive a=b ball=2 ball=nan =1 0,0,2,2 0,0,0,0 -1,0,2,2 1,1,9999999999,1 1-2 2-1 1-99 . / nothing.png "
        "llvm_ad_rgb scalar_rgb localhost localhost:1 é"
    ),
    *["", " ", "a" * 3000],
)
LINES = (
    "spp = 1",
    "spp = nan",
    "spp = [1]",
    'spp = "1"',
    "size = 0",
    "crop = [0, 0, 2]",
    'crop = "0,0,2,2"',
    "sensor = [0, 0]",
    "sensor = []",
    "sensor = -1",
    "sensor = 1.5",
    "define = {a = 1}",
    "define = 3",
    'define = ["a"]',
    "define = [1]",
    'frames = "1-3"',
    "frames = 3",
    "shape_weights = {ball = 2}",
    "shape_weights = 3",
    "shape_weights = {ball = inf}",
    "criterion = 3",
    "unbiased = 3",
    "importance = 3",
    "checkpoint = 3",
    "settings = {spp = 1}",
    'scene = "x"',
    "[render]",
    "= 1",
    "spp = 1\nspp = 2",
    "\0",
    "time = 1979-05-27",
)


def options(random, folder):
    words = []
    for _ in range(random.choice([1, 1, 1, 2])):
        option = random.choice(OPTIONS)
        value = random.choice(VALUES)
        if option in ("--checkpoint", "--live"):
            value = str(folder.parent / "out" / ("state.ckpt" if option == "--checkpoint" else "live.png"))
        words += [option, value]
        words += (
            [random.choice(["--unbiased", "--resume", "--overwrite", "--features", "--denoise"])]
            if random.random() < 0.15
            else []
        )
    small = [] if {"--time", "--noise", "--spp"}.isdisjoint(words) else ["--max-spp", "9"]
    return render(folder, xml(SCENES["plain"]), *words, *small)


def configurations(random, folder):
    path = folder / "render.toml"
    path.write_text("\n".join(random.sample(LINES, random.choice([1, 1, 2]))))
    return render(folder, xml(SCENES["plain"]), "--config", str(path))
