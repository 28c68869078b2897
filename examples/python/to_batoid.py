"""The fitted terms in batoid: Zernikes, or a bicubic surface with our derivatives, on a parabola.

batoid has metres and traces rays, so its spot is that of the terms without diffraction; the comparison is
with aberfit's own rays. batoid's Zernikes are annular ones by Noll's index from 1, with heights along the
axis, like ours.
"""

import batoid
import numpy as np

import pair

result, _ = pair.fitted_pair()
surface = result.surface
terms = np.concatenate([[0.0], surface.to_noll()])
nodes = np.linspace(-0.5 * pair.DIAMETER, 0.5 * pair.DIAMETER, 401)
x, y = np.meshgrid(nodes, nodes)
z, (dzdx, dzdy) = surface.heights(x, y), surface.slopes(x, y)
step = 1e-5
dzdxdy = (surface.slopes(x, y + step)[0] - surface.slopes(x, y - step)[0]) / (2 * step)
shapes = {
    "Zernike": batoid.Zernike(list(terms), R_outer=surface.radius),
    "bicubic": batoid.Bicubic(nodes, nodes, z, dzdx, dzdy, dzdxdy),
}
expected = pair.energies_by_rays(surface)
for name, shape in shapes.items():
    mirror = batoid.Sum([batoid.Paraboloid(2 * pair.FOCAL_LENGTH), shape])
    optic = batoid.Mirror(mirror, name="M1")
    rng = np.random.default_rng(1)
    r, t = 0.5 * pair.DIAMETER * np.sqrt(rng.uniform(size=200000)), rng.uniform(0, 2 * np.pi, 200000)
    rays = batoid.RayVector(
        r * np.cos(t),
        r * np.sin(t),
        np.full(r.size, 1.0),
        np.zeros(r.size),
        np.zeros(r.size),
        np.full(r.size, -1.0),
        0.0,
        pair.WAVELENGTH,
    )
    optic.trace(rays)
    focus = batoid.Plane()
    focus.intersect(rays, coordSys=batoid.CoordSys(origin=[0, 0, pair.FOCAL_LENGTH]))
    distance = np.sort(np.hypot(rays.x, rays.y))
    theirs = np.searchsorted(distance, pair.RADII) / distance.size
    print(name, np.round(expected, 4), np.round(theirs, 4))
    if np.max(np.abs(theirs - expected)) > 5e-3:
        raise SystemExit(f"batoid's {name} differs")
