"""MJCF: elements, attributes and numbers of a MuJoCo model changed; sizes that explode; files that lie elsewhere."""

from copy import deepcopy
from random import Random
from xml.etree import ElementTree

from fuzz.mutate import nasty, text

Element = ElementTree.Element
NUMBERS = (
    "nan", "inf", "-1", "0", "1e400", "1e308", "1e-300", "9" * nasty.DIGITS, "abc", "", "1 2", "1 2 3 4 5 6 7 8 9",
    "0 0 0",
    "0 0 0 0", "1;2", "0x10", "nan nan nan", "3000000", "-0", "1,0,0",
)  # fmt: skip
FILES = (
    f"{nasty.OUTSIDE}/kept.xml", "../outside/kept.xml", f"{nasty.OUTSIDE}/kept.stl", "../outside/kept.stl", "/dev/zero",
    "/etc/hostname", "hinge.xml", "my.xml", "x" * 5_000, "", "..", "kept.png",
)  # fmt: skip
BODIES = (
    "body",
    "geom",
    "site",
    "joint",
    "frame",
    "replicate",
    "composite",
    "flexcomp",
    "freejoint",
    "inertial",
    "camera",
)
NAMES = ("segment1", "segment2", "imu1", "imu2", "hinge", "base", "imu1_slide_x", "world", "")


def mutate(content: bytes, rng: Random) -> bytes:
    """Return MJCF with changed elements, attributes, sizes, files or text."""
    if rng.random() < 0.2:
        return text.mutate(content, rng)
    try:
        root = ElementTree.fromstring(content)
    except ElementTree.ParseError:
        return text.mutate(content, rng)
    for _ in range(1 + min(int(rng.expovariate(1.0)), 3)):
        (_bomb if rng.random() < 0.35 else _change)(root, rng)
    out = ElementTree.tostring(root)
    return (
        out.replace(b"<worldbody>", b"<worldbody>" + nested(rng.choice((200, nasty.DEEP))), 1)
        if rng.random() < 0.02
        else out
    )


def nested(depth: int) -> bytes:
    """Return bodies within bodies."""
    return b"<body>" * depth + b"</body>" * depth


def _change(root: Element, rng: Random) -> None:
    element = rng.choice(list(root.iter()))
    kind = rng.randrange(9)
    key = rng.choice(list(element.attrib) or ["name"])
    if kind < 3:
        element.set(key, rng.choice(NUMBERS))
    elif kind == 3:
        element.set(rng.choice(("name", key)), rng.choice((*NAMES, _attribute(nasty.text(rng)))))
    elif kind == 4:
        element.attrib.pop(key, None)
    elif kind == 5:
        for parent in root.iter():
            if element in list(parent):
                parent.remove(element)
                break
    elif kind == 6:
        rng.choice(list(root.iter())).append(deepcopy(element))
    elif kind == 7:
        element.tag = rng.choice((*BODIES, "worldbody", "asset", "sensor", "default", "mujoco", "nothing"))
    else:
        numbers = element.get(key, "").split()
        if numbers:
            numbers[rng.randrange(len(numbers))] = rng.choice(NUMBERS)
        element.set(key, " ".join(numbers))


def _attribute(value: str) -> str:
    """Return a text without what no XML can hold."""
    return "".join(c for c in value if c in "\t\n\r" or c >= " ")


def _bomb(root: Element, rng: Random) -> None:
    """Add what is a line in the file and very large once it is compiled, or what leads out of the folder."""
    world = root.find("worldbody")
    world = root if world is None else world
    add, kind = ElementTree.SubElement, rng.randrange(16)
    if kind == 0:
        add(
            add(world, "replicate", count=rng.choice(("3000000", "100000", "-1", "0")), offset="1 0 0"),
            "geom",
            size=".1",
        )
    elif kind == 1:
        outer = add(world, "replicate", count="3000", offset="1 0 0")
        add(add(outer, "replicate", count="3000", offset="0 1 0"), "site")
    elif kind == 2:
        add(rng.choice((root, world)), "include", file=rng.choice(FILES))
    elif kind == 3:
        assets = add(root, "asset")
        add(assets, "mesh", name="m", file=rng.choice(FILES))
        add(world, "geom", type="mesh", mesh="m")
    elif kind == 4:
        add(
            add(root, "asset"),
            "hfield",
            name="h",
            file=rng.choice((*FILES, f"{nasty.OUTSIDE}/kept.png")),
            size="1 1 1 1",
        )
    elif kind == 5:
        add(add(root, "asset"), "hfield", name="h", nrow="40000", ncol="40000", size="1 1 1 1")
    elif kind == 6:
        add(add(root, "asset"), "texture", name="t", type="2d", file=rng.choice((*FILES, f"{nasty.OUTSIDE}/kept.png")))
    elif kind == 7:
        size = rng.choice(("30000", "1000000"))
        add(add(root, "asset"), "texture", name="t", type="2d", builtin="flat", width=size, height=size)
    elif kind == 8:
        add(
            root,
            "size",
            **{
                rng.choice(("memory", "nconmax", "njmax", "nuserdata", "nkey", "nstack")): rng.choice(
                    ("100G", "2000000000", "-5", "x")
                )
            },
        )
    elif kind == 9:
        add(root, "compiler", meshdir=nasty.OUTSIDE, texturedir="..", assetdir="../outside", autolimits="x")
    elif kind == 10:
        flex = {"type": "grid", "count": rng.choice(("1000 1000 1", "300 300 300")), "spacing": ".1 .1 .1", "name": "f"}
        add(world, "flexcomp", **flex, radius=".01")
    elif kind == 11:
        add(world, "composite", type="cable", curve="s", count="2000000 1 1", size="1")
    elif kind == 12:
        add(add(root, "extension"), "plugin", plugin=rng.choice(("mujoco.elasticity.cable", "mujoco.sdf.bolt", "x")))
    elif kind == 13:
        assets = add(root, "asset")
        add(assets, "model", name="other", file=rng.choice(FILES))
        add(world, "attach", model="other", body="segment1", prefix="x")
    elif kind == 14:
        add(
            root,
            "option",
            timestep=rng.choice(("nan", "1e-300", "1e300", "-1", "0")),
            gravity=rng.choice(NUMBERS),
            integrator="RK4",
        )
    else:
        add(add(root, "keyframe"), "key", qpos="1 " * rng.choice((1, 100_000)))
