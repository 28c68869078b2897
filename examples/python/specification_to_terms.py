# %% [markdown]
# # From a specification to terms and scatter
# A notebook as a script: each `# %%` is a cell. It needs aberfit and matplotlib.

# %%
import matplotlib.pyplot as plt
import numpy as np

import aberfit

study = {
    "aberfit": 1,
    "title": "0.3 m f/4 primary mirror, 20 nm RMS",
    "mirror": {"focal_length": "1.2 m"},
    "aperture": {"shape": "annulus", "diameter": "0.3 m", "inner_diameter": "90 mm"},
    "light": {"wavelength": "550 nm"},
    "roughness": {
        "psd": {
            "model": "k-correlation",
            "rms": "20 nm",
            "B": "60 mm",
            "exponent": 3,
            "f_min": "3.4 /m",
            "f_max": "100 /m",
        }
    },
}
result = aberfit.fit(study)
result

# %% [markdown]
# ## Encircled energy of theory and of the fitted surface

# %%
best = int(np.argmin(np.abs(result.plane)))
fig, ax = plt.subplots()
ax.semilogx(result.radius[1:] * 1e6, result.theory.encircled_energy[best, 1:], label="Harvey-Shack theory")
ax.semilogx(result.radius[1:] * 1e6, result.focus.encircled_energy[best, 1:], "--", label="fitted surface")
ax.set(xlabel="radius [um]", ylabel="encircled energy", title=study["title"])
ax.legend()
fig.savefig("encircled_energy.png", dpi=120)

# %% [markdown]
# ## The surface, and what is left to scatter

# %%
x, height = result.surface.grid(257)
fig, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
picture = left.pcolormesh(x, x, height * 1e9, shading="nearest")
fig.colorbar(picture, ax=left, label="height [nm]")
left.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
f, s = result.surface.psd()
psd = aberfit.Psd(**study["roughness"]["psd"])
right.loglog(f, s, label="fitted surface")
right.loglog(f, psd(f), "--", label="specification")
right.set(xlabel="frequency [1/m]", ylabel="PSD [m^4]", ylim=(1e-22, 1e-16))
right.legend()
fig.savefig("surface.png", dpi=120)
halo = result.halo
print(f"RMS of the terms {result.surface.rms(inner_radius=0.045) * 1e9:.2f} nm; {halo}")

# %% [markdown]
# ## For other programs

# %%
for format in ("coefficients-csv", "zemax-grid-sag", "fits-opd"):
    print(result.surface.write(".", format, wavelength=550e-9))
