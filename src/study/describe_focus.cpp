#include "describe.h"

namespace aberfit::internal {

void describe_extent_in_focus(Visitor& v, const Field& field,
                              std::optional<std::variant<std::string, double>>& value) {
  const char* const angle = R"(\s*[0-9.eE+-]+\s*(rad|mrad|urad|nrad|deg|arcmin|arcsec|mas)\s*)";
  Visitor::WordOrQuantity held = value.value_or(std::string());
  const bool given = value.has_value();
  v.word_or_quantity(field, held, angle, kLength, Range::positive());
  const auto* text = std::get_if<std::string>(&held);
  if (!given && text && text->empty()) return;
  if (text) {
    double angle_of = 0;
    try {
      angle_of = parse_quantity(*text, kAngle);
    } catch (const UnitError& error) {
      v.check(false, field.key, error.what(), "a length or an angle");
    }
    v.check(angle_of > 0, field.key, *text, "above zero");
  }
  value = held;
}

void describe_focus(Visitor& v, FocusSpec& focus) {
  v.text({"file",
          "encircled-energy curve (columns radius_um or diameter_arcsec, share and optionally noise) or "
          "image (FITS, or a matrix of numbers), relative to the study",
          kRequired, "\"ee.csv\""},
         focus.file, false);
  v.word({"kind", "content of the file; auto: FITS and more than three columns are images"}, focus.kind,
         {"auto", "curve", "image"});
  v.text(
      {"radius_unit", "unit of the radii of a curve whose first row does not name it", kOptional, "\"um\""},
      focus.radius_unit, true);
  v.quantity({"plane", "distance from the nominal focus [m]", kOptional, "\"0 mm\""}, focus.measured.dz,
             kLength, Range::any());
  describe_extent_in_focus(v,
                           {"pixel",
                            "side of the detector's pixels, as length or as angle on the sky. Absent: for an "
                            "image, as its file says; for a curve, no pixels",
                            kOptional, "\"5 um\""},
                           focus.pixel);
  describe_extent_in_focus(
      v,
      {"reach", "largest distance from the centre that is used; absent: no limit", kOptional, "\"200 um\""},
      focus.reach);
  v.quantity(
      {"noise",
       "standard deviation of a share, or of a pixel in the image's unit. Absent: the file's column, the rim "
       "of an image (if it has none, 0.001 of the brightest pixel), or the residuals (for one mirror 0.001)",
       kOptional, "0.002"},
      focus.measured.noise, kNumber, Range::positive());
  v.quantity({"gain", "photoelectrons per unit of the image, for its shot noise", kOptional, "2"},
             focus.measured.gain, kNumber, Range::positive());
  std::string total = focus.measured.is_total_known ? "known" : "free";
  v.word(
      {"total", "for a curve: whether shares are fractions of the total energy, or of a part that is fitted"},
      total, {"known", "free"});
  focus.measured.is_total_known = total == "known";
  std::string background = focus.measured.has_background ? "free" : "none";
  v.word({"background", "for an image: uniform background is fitted, or there is none"}, background,
         {"free", "none"});
  focus.measured.has_background = background == "free";
  std::string of = focus.measured.is_one_mirror ? "mirror" : "mean";
  v.word({"of",
          "mirror: one mirror was measured, whose focus differs from the mean of its specification; mean: "
          "many were"},
         of, {"mirror", "mean"});
  focus.measured.is_one_mirror = of == "mirror";
  v.quantity({"confidence", "confidence of the intervals"}, focus.measured.confidence, kNumber,
             Range{0.5, 1, true, true});
}

}  // namespace aberfit::internal
