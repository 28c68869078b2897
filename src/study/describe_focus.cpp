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
  v.text(
      {"file",
       "encircled-energy curve (columns radius_um or diameter_arcsec, share and, if wanted, noise) or image "
       "(FITS, or a matrix of numbers), relative to the study",
       kRequired, "\"ee.csv\""},
      focus.file, false);
  v.word({"kind", "what the file holds; auto: FITS and more than three columns are images"}, focus.kind,
         {"auto", "curve", "image"});
  v.text({"radius_unit", "of a curve whose first row does not say it", kOptional, "\"um\""},
         focus.radius_unit, true);
  v.quantity({"plane", "distance from the nominal focus [m]", kOptional, "\"0 mm\""}, focus.measured.dz,
             kLength, Range::any());
  describe_extent_in_focus(
      v,
      {"pixel",
       "side of the detector's pixels, as length or as angle on the sky: of an image (absent: "
       "its file says it), or that a curve was counted with (absent: none)",
       kOptional, "\"5 um\""},
      focus.pixel);
  describe_extent_in_focus(
      v, {"reach", "what is further from the centre is left out; absent: nothing", kOptional, "\"200 um\""},
      focus.reach);
  v.quantity(
      {"noise",
       "standard deviation of a share, or of a pixel in the image's unit; absent: the file's own column, "
       "the rim of an image, or the residuals (of one mirror 0.001; of an image without any at its rim 0.001 "
       "of its brightest pixel)",
       kOptional, "0.002"},
      focus.measured.noise, kNumber, Range::positive());
  v.quantity({"gain", "photoelectrons in a unit of the image, for its shot noise", kOptional, "2"},
             focus.measured.gain, kNumber, Range::positive());
  std::string total = focus.measured.is_total_known ? "known" : "free";
  v.word({"total", "of a curve: whether shares are of all of the light, or of a part that is fitted"}, total,
         {"known", "free"});
  focus.measured.is_total_known = total == "known";
  std::string background = focus.measured.has_background ? "free" : "none";
  v.word({"background", "of an image: an even one is fitted, or there is none"}, background,
         {"free", "none"});
  focus.measured.has_background = background == "free";
  std::string of = focus.measured.is_one_mirror ? "mirror" : "mean";
  v.word({"of",
          "mirror: one was measured, whose focus departs from the mean light of its specification; mean: of "
          "many"},
         of, {"mirror", "mean"});
  focus.measured.is_one_mirror = of == "mirror";
  v.quantity({"confidence", "of the intervals"}, focus.measured.confidence, kNumber,
             Range{0.5, 1, true, true});
}

}  // namespace aberfit::internal
