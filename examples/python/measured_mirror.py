# %% [markdown]
# # From a measured mirror to its PSD and its focus
# The profile is made here, so that its PSD is known. Use `np.loadtxt` for your own.

# %%
import matplotlib.pyplot as plt
import numpy as np

import aberfit

rng = np.random.default_rng(3)
n, pitch = 4096, 0.5e-3
f = np.fft.rfftfreq(n, pitch)
true = np.zeros_like(f)
true[1:] = 2e-19 / f[1:] ** 2  # one-sided profile PSD [m^3]
spectrum = np.sqrt(true / 2 * n / pitch / 2) * (rng.normal(size=f.size) + 1j * rng.normal(size=f.size))
profile = aberfit.Profile(np.arange(n) * pitch, np.fft.irfft(spectrum, n))

# %%
study = {
    "aberfit": 1,
    "title": "A measured mirror",
    "mirror": {"focal_length": "10 m"},
    "aperture": {"shape": "circle", "diameter": "1 m"},
    "light": {"wavelength": "632.8 nm"},
    "roughness": {"psd": {"model": "measured", "file": "profile"}},
}
measured = aberfit.psd(study, profile=profile)
print(measured)

# %% [markdown]
# ## The PSD and its model

# %%
bins = measured["estimate"]["bins"]
centre = np.array([b["frequency_per_m"] for b in bins])
value = np.array([b["psd_m3"] for b in bins])
model = aberfit.Psd(**measured["roughness"]["psd"])
fig, ax = plt.subplots()
ax.loglog(centre, value, "o", label="bins of the profile")
ax.loglog(f[1:], true[1:], "-", label="truth")
ax.set(xlabel="frequency [1/m]", ylabel="one-sided profile PSD [m^3]")
ax.legend()
fig.savefig("measured_psd.png", dpi=120)
print(f"RMS of the model between 10 and 500 /m: {model.rms(10, 500) * 1e9:.2f} nm")

# %% [markdown]
# ## The mean focus of such mirrors

# %%
light = aberfit.ghs({**study, "roughness": measured["roughness"]})
radius = np.geomspace(1e-6, 1e-3, 200)
fig, ax = plt.subplots()
ax.semilogx(radius * 1e6, light.encircled_energy(radius))
ax.set(xlabel="radius [um]", ylabel="encircled energy", title=f"TIS {100 * light.tis:.2f} %")
fig.savefig("measured_focus.png", dpi=120)
