#pragma once
namespace aberfit::internal {

/// Names of the surfaces of a MapLight, in the order of its columns: in files, and for people.
struct MapColumnName {
  const char* key;
  const char* label;
};
inline constexpr MapColumnName kMapColumns[] = {{"measured", "measured map"},
                                                {"terms", "terms alone"},
                                                {"terms_and_residual_psd", "terms + PSD"},
                                                {"perfect", "perfect mirror"}};

}  // namespace aberfit::internal
