#include "glossary.h"

#include <regex>

namespace aberfit::internal {
namespace {

struct Word {
  const char* seen;  // regular expression; the word is explained where it matches
  const char* name;
  const char* meaning;
};

constexpr Word kStatistics[] = {
    {R"(\bee\d)", "ee80",
     "circle about the centre of the spot that holds 80 % of the energy, by its radius (ee80_radius, or ee80 "
     "alone) or its diameter; other numbers likewise"},
    {R"(\bhew\b)", "hew", "half-energy width, the diameter that holds 50 % of the energy"},
    {R"(\bensquared\d)", "ensquared80", "side of the square that holds 80 % of the energy; others likewise"},
    {R"(\bee_within\b)", "ee_within", "fraction of the energy inside a given radius"},
    {R"((radius|diameter|side|within|fwhm)@-?\d)", "@-0.02mm",
     "in the plane 0.02 mm before the focal plane z = f; a positive number is behind it"},
    {R"(\bring_fwhm\b)", "ring_fwhm",
     "depth of focus: full width at half maximum, along the axis, of the energy inside one ring. The ring "
     "holds 90 % of the energy at z = f, or as @ring says"},
    {R"(\bscatter_(rms|mean)\b)", "scatter_rms, scatter_mean",
     "RMS and mean angle between a reflected ray and that of the perfect mirror"},
    {R"(\bspot_fwhm\b)", "spot_fwhm", "full width at half maximum of the line spread function"},
    {R"([^_]\bfwhm\b)", "fwhm", "full width at half maximum of the irradiance"},
    {R"(\brms_radius\b)", "rms_radius", "RMS radius of the spot of rays"},
    {R"(\brms_height\b)", "rms_height", "RMS height of the surface error over the aperture"},
    {R"([Ss]trehl)", "Strehl ratio", "highest irradiance in the focus over that of the perfect mirror"},
    {R"(\bmtf\b)", "mtf", "modulation transfer function, at z = f"},
    {R"(\bpssn\b)", "pssn",
     "normalised point source sensitivity through air (Seo et al. 2009); 1 is perfect"},
    {R"(\b(TIS|tis)\b)", "TIS", "total integrated scatter: fraction of the energy that is scattered"}};

constexpr Word kScene[] = {
    {R"(k-correlation)", "k-correlation",
     "PSD proportional to (1 + (B f)^2)^(-exponent/2); its knee is at the frequency f = 1/B"},
    {R"(A/f\^B|power-law)", "A/f^B", "PSD that is a straight line on logarithmic axes, here with exponent B"},
    {R"(\bg (\d|=))", "g", "4 pi times the RMS height over the wavelength: RMS phase of the reflected wave"},
    {R"(\bkappa\b)", "kappa",
     "measure of how nearly quadratic the structure function is; geometric rays can be valid from 0.85 up"},
    {R"(modes)", "modes (N_eff)", "number of independent surface waves that carry the slope"},
    {R"(Airy ee90)", "Airy ee90", "radius that holds 90 % of the energy of the perfect mirror"},
    {R"((the paper's R|R of the paper))", "R of the paper",
     "2 sigma D/(1.22 lambda l_c), with RMS height, aperture, wavelength and correlation length; for "
     "information only"},
    {R"(\b(ghs|GHS|[Gg]eneralised Harvey-Shack)\b)", "ghs",
     "generalised Harvey-Shack: scalar wave-optics theory of the mean PSF of a rough surface"},
    {R"(\b([Rr]ealisations?)\b)", "realisation", "one random surface with the specified PSD"},
    {R"(\bterms\b)", "terms",
     "Zernike polynomials, plane (Fourier) waves or even powers of the radius; their sum is the surface "
     "error"},
    {R"(\bABg\b)", "ABg", "scatter model BSDF = A/(B + s^g), with s the sine of the scatter angle"}};

constexpr Word kJudgement[] = {
    {R"(\b(equivalent|EQUIVALENT|UNDECIDED|undecided)\b)", "equivalent",
     "the confidence interval of the difference lies inside the margin on both sides; different: it lies "
     "wholly outside; undecided: it reaches across a limit"},
    {R"(90 % interval)", "90 % interval",
     "inside the margin it proves equivalence at 95 % confidence, because each of its two ends is a "
     "one-sided test"},
    {R"((\d|in) tolerances|\[tol)", "tolerance",
     "unit of differences: the margin of the verdict. In the paragraph \"Fit\" it is the narrower tolerance "
     "of the targets in result.json"},
    {R"((held out|Held out))", "held out", "judged, but not used by the fit"},
    {R"(fresh (grid|rays))", "fresh", "computed on points that the fit did not use"},
    {R"(\bguides\b)", "guides", "further values that steer the fit and are not judged"},
    {R"("\*")", "*", "the budget that limits the result"},
    {R"("room")", "margin, room",
     "distance of the value from its limit: in per cent of the limit, and in its unit"},
    {R"(%/% )", "%/%", "per cent by which the value changes when that number of the roughness grows by 1 %"},
    {R"(p-value)", "p-value",
     "probability that chance alone makes the model fit this badly; below 0.001 it does not describe the "
     "data"}};

}  // namespace

std::vector<NamedPurpose> words_in(const std::string& text) {
  std::vector<NamedPurpose> words;
  const auto look = [&](const auto& list) {
    for (const Word& word : list)
      if (std::regex_search(text, std::regex(word.seen))) words.push_back({word.name, word.meaning});
  };
  look(kStatistics), look(kScene), look(kJudgement);
  return words;
}

}  // namespace aberfit::internal
