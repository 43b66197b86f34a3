"""What other programs read in the trajectories of a folder: `column` of the example `trajectory`, and `box`, with the numbers
of our observers in `box.txt`. Fails at the first difference; a program that is not installed is left out."""

import importlib
import importlib.metadata
import sys

import numpy

folder = sys.argv[1]
# Half of the last bit of single precision, for numbers of magnitude 1.
SINGLE = 2.0**-24


def program(name):
    try:
        return importlib.import_module(name)
    except ImportError as error:
        print(f"skipped: {name}: {error}")
        return None


def by_hand(name):
    """Frames of an extended XYZ file: sweep and centers."""
    lines = open(f"{folder}/{name}.xyz").read().splitlines()
    count = int(lines[0])
    frames = [lines[begin : begin + count + 2] for begin in range(0, len(lines), count + 2)]
    return [
        (int(frame[1].split("sweep=")[1].split()[0]), numpy.array([row.split()[1:4] for row in frame[2:]], float))
        for frame in frames
    ]


# Height and widths of the slabs.
SLABS = {"column": [80.0, 8.0, 7.5], "box": [12.0, 8.0, 7.5]}
FRAMES = {name: by_hand(name) for name in SLABS}
assert len(FRAMES["column"]) == 50 and len(FRAMES["box"]) == 64
assert [sweep for sweep, _ in FRAMES["column"]] == [10 * number for number in range(1, 51)]


def box_of(name):
    """What GSD says: longer than the slab by half the smaller width."""
    height, *widths = SLABS[name]
    return [height + 0.5 * min(widths), *widths]


def same(frames, name, tolerance, shift=0.0):
    """The centers of frames that a program has read, against those of the file."""
    assert len(frames) == len(FRAMES[name]), len(frames)
    for (sweep, expected), (other, positions) in zip(FRAMES[name], frames):
        assert other is None or other == sweep, (other, sweep)
        difference = numpy.abs(positions + shift - expected).max()
        assert difference <= tolerance, (name, sweep, difference)


def read_by_ase(ase_io):
    for name, slab in SLABS.items():
        frames = ase_io.read(f"{folder}/{name}.xyz", index=":", format="extxyz")
        same([(frame.info["sweep"], frame.positions) for frame in frames], name, 0.0)
        for frame in frames:
            assert (frame.cell.array == numpy.diag(slab)).all() and list(frame.pbc) == [False, True, True]
            assert (frame.arrays["radius"] == 0.5).all() and set(frame.get_chemical_symbols()) == {"X"}
        # Hard spheres do not overlap, periodic images included, as ASE measures it.
        distances = frames[-1].get_all_distances(mic=True) + 2.0 * numpy.eye(len(frames[-1]))
        assert distances.min() >= 1.0 - 1e-12, distances.min()
        heights = frames[-1].positions[:, 0]
        assert (heights >= 0.5).all() and (heights <= slab[0] - 0.5).all(), "centers beyond the walls"


def read_by_gsd(gsd_hoomd):
    for name, slab in SLABS.items():
        with gsd_hoomd.open(f"{folder}/{name}.gsd") as frames:
            # Single precision of half the slab, and exactly.
            rounded = [(frame.configuration.step, frame.particles.position) for frame in frames]
            same(rounded, name, SINGLE * 64, 0.5 * numpy.array(slab))
            same([(None, frame.log["particles/exact_position"]) for frame in frames], name, 0.0)
            for frame in frames:
                frame.validate()
                assert frame.configuration.dimensions == 3 and frame.particles.types == ["X"]
                assert list(frame.configuration.box) == [*box_of(name), 0, 0, 0], frame.configuration.box
                assert (frame.particles.diameter == 1).all() and (frame.particles.typeid == 0).all()
                assert list(frame.log["slab"]) == slab
                assert (numpy.abs(frame.particles.position) <= 0.5 * frame.configuration.box[:3]).all()


def read_by_ovito(ovito_io):
    for name, slab in SLABS.items():
        # OVITO rounds decimal numbers in its own way, up to the last bit.
        for kind, tolerance in [("xyz", 2.0**-52 * slab[0]), ("gsd", SINGLE * 64)]:
            pipeline = ovito_io.import_file(f"{folder}/{name}.{kind}")
            frames = [pipeline.compute(number) for number in range(pipeline.num_frames)]
            sweep = "sweep" if kind == "xyz" else "Timestep"
            shift = 0.0 if kind == "xyz" else 0.5 * numpy.array(slab)
            same([(frame.attributes[sweep], frame.particles.positions[...]) for frame in frames], name, tolerance, shift)
            for frame in frames:
                cell = numpy.array(frame.cell[...])
                assert (cell[:, :3] == numpy.diag(slab if kind == "xyz" else box_of(name))).all(), cell
                assert (cell[:, 3] == (0.0 if kind == "xyz" else -0.5 * numpy.diag(cell))).all(), cell
                assert tuple(frame.cell.pbc) == (kind == "gsd", True, True), frame.cell.pbc
                assert (frame.particles["Radius"][...] == 0.5).all()


def read_by_mdanalysis(analysis):
    for name, slab in SLABS.items():
        universe = analysis.Universe(f"{folder}/{name}.gsd")
        frames = [(None, step.positions.astype(float)) for step in universe.trajectory]
        same(frames, name, SINGLE * 64, 0.5 * numpy.array(slab))
        assert list(universe.dimensions[:3]) == box_of(name)


def numbers():
    """What our observers found."""
    found = {"g": [], "bonds": {}}
    for line in open(f"{folder}/box.txt"):
        key, *values = line.split()
        if key == "g":
            found["g"].append([float(value) for value in values])
        elif key == "bonds":
            found["bonds"][int(values[0])] = [float(value) for value in values[1:]]
        else:
            found[key] = float(values[0])
    return found


# freud calculates in single precision. A coordinate of at most half a box of 16 is known to 8 SINGLE and gets an error of
# that order in each of the few operations that wrap it and subtract another: no more than ten of them.
SEPARATION = 10 * 8 * SINGLE


def separations(first, second, widths):
    difference = first[:, None, :] - second[None, :, :]
    return difference - widths * numpy.round(difference / widths)


def compare_with_freud(freud, frames, source):
    """Frames as sweep-ordered centers from the middle of the box, in single or double precision."""
    expected = numbers()
    height, *widths = SLABS["box"]
    layer_box, widths = freud.box.Box(Lx=widths[0], Ly=widths[1], is2D=True), numpy.array(widths)

    def require(what, found, ours, tolerance):
        worst = (numpy.abs(found - ours) / tolerance).max()
        print(f"freud, {source}: {what} differs by at most {worst:.2g} of what rounding allows")
        assert worst <= 1, what

    longest, bins, cutoff = 3.0, len(expected["g"]), 1.4
    edges = numpy.linspace(0.0, longest, bins + 1)
    areas = numpy.pi * (edges[1:] ** 2 - edges[:-1] ** 2)
    pairs, unsure, spheres, local, total = numpy.zeros(bins), numpy.zeros(bins), [], [], []
    for positions in frames:
        heights = positions[:, 0] + 0.5 * height
        # No sphere is so near the edge of the layer that rounding takes it in or out.
        assert (numpy.abs(heights - 1.0) > SEPARATION).all()
        layer = positions[heights < 1.0]
        points = numpy.column_stack([layer[:, 1:], numpy.zeros(len(layer))])
        distribution = freud.density.RDF(bins=bins, r_max=longest)
        distribution.compute((layer_box, points))
        # Ordered pairs of this frame.
        pairs += distribution.rdf * len(points) ** 2 * areas / widths.prod()
        distances = numpy.linalg.norm(separations(points[:, :2], points[:, :2], widths), axis=2)
        near = (numpy.abs(distances[:, :, None] - edges) < SEPARATION) & ~numpy.eye(len(points), dtype=bool)[:, :, None]
        at_edge = near.sum(axis=(0, 1))
        unsure += at_edge[1:] + at_edge[:-1]
        assert (numpy.abs(distances - cutoff) > SEPARATION).all(), "a neighbor that rounding takes in or out"
        hexatic = freud.order.Hexatic(k=6)
        hexatic.compute((layer_box, points), neighbors={"r_max": cutoff, "exclude_ii": True})
        order = numpy.nan_to_num(hexatic.particle_order)
        spheres.append(len(points))
        local.append(numpy.abs(order).sum())
        total.append(numpy.abs(order.sum()))
    scale = numpy.mean(spheres) ** 2 * areas / widths.prod() * len(frames)
    ours = numpy.array(expected["g"])[:, 1]
    assert numpy.allclose(numpy.array(expected["g"])[:, 0], 0.5 * (edges[1:] + edges[:-1]), rtol=0, atol=1e-12)
    # Whole pairs that rounding moves to the next bin; and the area of a ring in single precision, the difference of two circles
    # of four roundings each.
    tolerance = unsure / scale + 4 * SINGLE * numpy.pi * (edges[1:] ** 2 + edges[:-1] ** 2) / areas * ours + 1e-12
    require("g(r)", pairs / scale, ours, tolerance)
    # Six times the error of an angle: that of a separation, whose length is at least 1, along each of two axes.
    tolerance = 6 * 2**0.5 * SEPARATION
    for name, sums in [("local", local), ("global", total)]:
        require(f"{name} hexatic order", numpy.sum(sums) / numpy.sum(spheres), expected[name], tolerance)

    # Bonds of the last frame, in the box as GSD has it.
    positions = frames[-1]
    box = freud.box.Box(*box_of("box"))
    heights = positions[:, 0] + 0.5 * height
    query = freud.locality.AABBQuery(box, positions)
    # As far as the box allows, no neighbor is across the walls.
    distance = 0.499 * widths.min()
    for first, second in query.query(positions, {"r_max": distance, "exclude_ii": True}).toNeighborList():
        assert abs(heights[first] - heights[second]) <= distance + SEPARATION, "neighbors across the walls"
    nearest = query.query(positions, {"num_neighbors": 13, "exclude_ii": True}).toNeighborList()
    lists = [[] for _ in positions]
    for (sphere, neighbor), length in zip(nearest, nearest.distances):
        lists[sphere].append((length, neighbor))
    lists = [sorted(near) for near in lists]
    at_wall = (heights < 1.0) | (heights > height - 1.0)
    # The thirteenth is farther than the twelfth for certain, and neither a neighbor nor what is averaged over is at a wall.
    sure = numpy.array([near[12][0] - near[11][0] > 2 * SEPARATION and near[11][0] < 1.5 for near in lists])
    sure &= ~at_wall
    comparable = [
        sphere
        for sphere, near in enumerate(lists)
        if sure[sphere] and all(sure[neighbor] for _, neighbor in near[:12])
    ]
    assert len(comparable) >= 50, len(comparable)
    bonds = numpy.array([expected["bonds"][sphere] for sphere in comparable])
    neighbors = {"num_neighbors": 12, "exclude_ii": True}

    def steinhardt(l, **options):
        order = freud.order.Steinhardt(l=l, average=True, **options)
        order.compute((box, positions), neighbors=neighbors)
        return order.particle_order[comparable]

    # The harmonics of order l turn l times as fast as the bond; the invariant w is divided by the cube of q.
    turn = 2**0.5 * SEPARATION
    for name, found, ours, tolerance in [
        ("q4", steinhardt(4), bonds[:, 0], 4 * turn),
        ("q6", steinhardt(6), bonds[:, 1], 6 * turn),
        ("w4", steinhardt(4, wl=True, wl_normalize=True), bonds[:, 2], 3 * 4 * turn / bonds[:, 0]),
    ]:
        require(f"averaged {name} of {len(comparable)} spheres", found, ours, tolerance)


for name, check in [("ase.io", read_by_ase), ("gsd.hoomd", read_by_gsd), ("ovito.io", read_by_ovito)]:
    module = program(name)
    if not module and check is read_by_ovito:
        name, check = "MDAnalysis", read_by_mdanalysis
        module = program(name)
    if module:
        check(module)
        distribution = name.split(".")[0]
        print(f"{distribution} {importlib.metadata.version(distribution)} reads every frame")
freud, gsd_hoomd = program("freud"), program("gsd.hoomd")
if freud:
    middle = 0.5 * numpy.array(SLABS["box"])
    compare_with_freud(freud, [positions - middle for _, positions in FRAMES["box"]], "extended XYZ")
    if gsd_hoomd:
        with gsd_hoomd.open(f"{folder}/box.gsd") as frames:
            compare_with_freud(freud, [frame.particles.position for frame in frames], "GSD")
