# %% [markdown]
# # From a budget to a roughness, and how the blur grows with it

# %%
import matplotlib.pyplot as plt
import numpy as np

import aberfit

study = {
    "aberfit": 1,
    "title": "How rough may a 1.2 m primary mirror be?",
    "mirror": {"focal_length": "2.4 m"},
    "aperture": {"shape": "annulus", "diameter": "1.2 m", "inner_diameter": "0.36 m"},
    "light": {"wavelength": "550 nm"},
    "roughness": {
        "psd": {
            "model": "k-correlation",
            "rms": "20 nm",
            "B": "0.3 m",
            "exponent": 3,
            "f_min": "1 /m",
            "f_max": "100 /m",
        }
    },
    "solve": {
        "for": ["/roughness/psd/rms"],
        "so_that": {"ee80_diameter": "<= 1 arcsec", "strehl": ">= 0.8"},
    },
}
solved = aberfit.solve(study)
print(solved)
allowed = solved["solutions"][0]["at"]["/roughness/psd/rms"]

# %% [markdown]
# ## The same numbers by hand, over the height

# %%
heights = np.linspace(2e-9, 40e-9, 20)
radii = []
for rms in heights:
    light = aberfit.ghs({**study, "roughness": {"psd": {**study["roughness"]["psd"], "rms": float(rms)}}})
    radii.append(light.encircled_energy_radius([0.5, 0.8]))
diameters = 2 * np.array(radii) / 2.4 * 206265
fig, ax = plt.subplots()
ax.plot(heights * 1e9, diameters[:, 0], label="50 % of the energy")
ax.plot(heights * 1e9, diameters[:, 1], label="80 % of the energy")
ax.axhline(1.0, linestyle=":")
ax.axvline(allowed * 1e9, linestyle=":")
ax.set(xlabel="RMS height [nm]", ylabel="diameter [arcsec]")
ax.legend()
fig.savefig("budget.png", dpi=120)

# %% [markdown]
# ## A sweep: every case is a study of its own

# %%
vary = {
    "over": {"/roughness/psd/rms": ["5 nm", "10 nm", "20 nm"], "/roughness/psd/B": ["0.1 m", "0.3 m"]},
    "run": "check",
}
for values, result in aberfit.sweep({**study, "vary": vary}):
    print(values, f"TIS {100 * result['scene']['tis']:.2f} %")
