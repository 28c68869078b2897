#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "aberfit/core/units.h"

// The study format is described once (describe.cpp); reading, writing the resolved study and writing the JSON
// Schema are three visitors of that description, so a key cannot be known to one and unknown to another.
namespace aberfit::internal {

/// A kUsual key may be absent in special studies. A message about missing required keys names it, too.
enum class Need { kRequired, kOptional, kUsual };

/// One key of an object: its name, its meaning (for the schema), and whether it may be absent. An absent
/// optional key leaves the structure's value, which is the default.
struct Field {
  const char* key;
  const char* meaning;
  Need need = Need::kOptional;
  const char* example = nullptr;  ///< JSON text for the schema
  const char* note = nullptr;     ///< sentence added to the error if the value is not allowed
};

/// Interval of allowed numbers in SI units.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false, high_open = false;

  static Range any() { return {}; }
  static Range positive() { return {0, std::numeric_limits<double>::infinity(), true, false}; }
  static Range non_negative() { return {0, std::numeric_limits<double>::infinity(), false, false}; }
  bool contains(double value) const {
    return (low_open ? value > low : value >= low) && (high_open ? value < high : value <= high);
  }
};

/// Limits `range` to numbers whose powers and products in a scene stay within double precision: lengths up to
/// 1e12 m, frequencies up to 1e15 per m. The small end of positive ranges is limited, too.
inline Range within_reach(Range range, Dimension dimension) {
  const double most = dimension == Dimension::kLength             ? 1e12
                      : dimension == Dimension::kSpatialFrequency ? 1e15
                                                                  : 1e100;
  const double least = dimension == Dimension::kLength             ? 1e-24
                       : dimension == Dimension::kSpatialFrequency ? 1e-15
                                                                   : 1e-100;
  if (range.low_open && range.low == 0) range.low = least, range.low_open = false;
  range.low = std::max(range.low, -most);
  if (range.high > most) range.high = most, range.high_open = false;
  return range;
}

/// Kinds of keys of an object whose keys are data (target.statistics).
struct KeyPattern {
  std::string literal;  ///< the key itself, or empty
  std::string regex;    ///< ECMA regular expression of the whole key when `literal` is empty
  std::string sample;   ///< a key of that kind
};

/// Limits and spacings of the ranges in `variations`.
inline constexpr std::int64_t kMostOfRange = 1000000;
inline const std::vector<std::string> kSpacings = {"linear", "log", "integers"};

/// Every call names a key of the object being visited. The reader reads values, the writer writes them, and
/// the schema documents them.
class Visitor {
 public:
  using Body = std::function<void(Visitor&)>;
  using ItemBody = std::function<void(Visitor&, std::size_t)>;  ///< describes the item of that index
  using Resize = std::function<void(std::size_t)>;              ///< makes room for as many items
  using Names = std::vector<std::string>;
  using WordOrQuantity = std::variant<std::string, double>;
  using NumberedQuantities = std::map<int, double>;
  using Points = std::vector<std::array<double, 2>>;
  using TextsByKey = std::vector<std::pair<std::string, std::string>>;
  virtual ~Visitor() = default;

  /// String with unit or plain SI number. Empty: absent.
  virtual void quantity(const Field& field, std::optional<double>& value, Dimension dimension,
                        Range range) = 0;
  /// Array of quantities; `ascending` means strictly.
  virtual void quantities(const Field& field, std::vector<double>& values, Dimension dimension, Range range,
                          bool ascending) = 0;
  /// A quantity or one of the words that match `regex` ("ee90").
  virtual void word_or_quantity(const Field& field, WordOrQuantity& value, const std::string& regex,
                                Dimension dimension, Range range) = 0;
  /// Object whose keys are whole numbers from `low` to `high` and whose values are such quantities.
  virtual void numbered_quantities(const Field& field, NumberedQuantities& values, int low, int high,
                                   Dimension dimension, Range range) = 0;
  /// Array of [x, y] lengths.
  virtual void points(const Field& field, Points& points, std::size_t least) = 0;
  virtual void integer(const Field& field, std::optional<std::int64_t>& value, std::int64_t low,
                       std::int64_t high) = 0;
  /// Any unsigned 64-bit integer.
  virtual void seed(const Field& field, std::uint64_t& value) = 0;
  virtual void boolean(const Field& field, bool& value) = 0;
  virtual void text(const Field& field, std::string& value, bool may_be_empty) = 0;
  /// Array of `least` to `most` texts, none of them empty.
  virtual void texts(const Field& field, Names& values, std::size_t least, std::size_t most) = 0;
  /// Object whose keys are data and whose values are texts that match `regex`; at least one.
  virtual void texts_by_key(const Field& field, TextsByKey& values, const std::vector<KeyPattern>& patterns,
                            const std::string& regex) = 0;
  /// Object whose keys are JSON pointers and whose values are arrays of any values or ranges of numbers; at
  /// least one. The values are held as JSON texts.
  virtual void variations(const Field& field, TextsByKey& values) = 0;
  virtual void choice(const Field& field, std::size_t& index, const Names& names) = 0;
  /// Array of distinct choices.
  virtual void choices(const Field& field, std::vector<std::size_t>& indices, const Names& names) = 0;
  /// The choice that decides which other keys the object has. It must be called before them.
  virtual void tag(const Field& field, std::size_t& index, const Names& names) {
    choice(field, index, names);
  }
  /// An object. `present` tells whether an optional object was given; null means always. `definition` names
  /// it in the schema; a description that contains itself needs this name.
  virtual void object(const Field& field, bool* present, const Body& body,
                      const char* definition = nullptr) = 0;
  /// Either one of the words, words[word], or an object.
  virtual void word_or_object(const Field& field, bool& is_object, const Names& words, std::size_t& word,
                              const Body& body) = 0;
  /// Either the word or an integer.
  virtual void word_or_integer(const Field& field, bool& is_word, const std::string& word,
                               std::int64_t& value, std::int64_t low, std::int64_t high) = 0;
  /// Array of objects.
  virtual void list(const Field& field, std::size_t count, std::size_t least, const Resize& resize,
                    const ItemBody& body, const char* definition = nullptr) = 0;
  /// Object whose keys are data; `keys` are its keys, `body` describes the value of keys[i].
  virtual void keyed(const Field& field, Names& keys, const std::vector<KeyPattern>& patterns,
                     const ItemBody& body) = 0;

  /// A rule between keys of the object being visited; only the reader checks it. If `holds` is false, `key`
  /// is at fault.
  virtual void check(bool /*holds*/, const std::string& /*key*/, const std::string& /*found*/,
                     const std::string& /*allowed*/) {}
  /// Returns whether values come from a file, so that a default may depend on other keys.
  virtual bool reading() const { return false; }

  // Shorthands for members that always have a value.
  void quantity(const Field& field, double& value, Dimension dimension, Range range) {
    std::optional<double> optional = value;
    quantity(field, optional, dimension, range);
    value = optional.value_or(value);
  }
  /// `none` and infinity are written as an absent key, which is read as `none`.
  void quantity_or(const Field& field, double& value, double none, Dimension dimension, Range range) {
    std::optional<double> optional;
    if (std::isfinite(value) && value != none) optional = value;
    quantity(field, optional, dimension, range);
    value = optional.value_or(none);
  }
  template <typename Integer>
  void integer(const Field& field, std::optional<Integer>& value, std::int64_t low, std::int64_t high) {
    std::optional<std::int64_t> wide = value;
    integer(field, wide, low, high);
    if (wide) value = Integer(*wide);
  }
  template <typename Integer>
  void integer(const Field& field, Integer& value, std::int64_t low, std::int64_t high) {
    std::optional<std::int64_t> optional = value;
    integer(field, optional, low, high);
    value = Integer(optional.value_or(value));
  }
  /// Enumerators in the order of `names`, counted from 0.
  template <typename Enum>
  void choice_of(const Field& field, Enum& value, const Names& names) {
    std::size_t index = std::size_t(value);
    choice(field, index, names);
    value = Enum(index);
  }
  /// One of `values` by its `to_string`, or empty: the word "auto".
  template <typename Enum>
  void choice_or_auto(const Field& field, std::optional<Enum>& value, const std::vector<Enum>& values) {
    Names names = {"auto"};
    std::size_t index = 0;
    for (const Enum each : values) {
      if (value == each) index = names.size();
      names.push_back(to_string(each));
    }
    choice(field, index, names);
    value = index == 0 ? std::nullopt : std::optional(values[index - 1]);
  }
  /// The tag of an object that is one of several alternatives. Each entry has its word and the value that
  /// reading starts from, in the order of the variant.
  template <typename Variant>
  void kind(const Field& field, Variant& held, const std::vector<std::pair<std::string, Variant>>& kinds) {
    Names names;
    for (const auto& [name, fresh] : kinds) names.push_back(name);
    std::size_t index = held.index();
    tag(field, index, names);
    if (index != held.index() || reading()) held = kinds[index].second;
  }
  /// An object that is present if its member is.
  template <typename Value>
  void optional_object(const Field& field, std::optional<Value>& value,
                       void (*describe)(Visitor&, std::type_identity_t<Value>&)) {
    bool present = value.has_value();
    object(field, &present, [&](Visitor& inside) {
      if (!value) value.emplace();
      describe(inside, *value);
    });
  }
  /// A choice stored as its word.
  void word(const Field& field, std::string& value, const Names& names) {
    std::size_t index = 0;
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == value) index = i;
    choice(field, index, names);
    value = names[index];
  }
};

/// Fills what `body` describes from `json`, strictly: unknown keys, wrong types, missing keys, bad units and
/// values out of range throw InputError with `file` and the JSON pointer.
void read_object(const nlohmann::ordered_json& json, const std::string& file, const Visitor::Body& body);

/// Writes what `body` describes as JSON, with all its values and with quantities as plain SI numbers.
nlohmann::ordered_json write_object(const Visitor::Body& body);

/// JSON Schema, draft 2020-12, of the object that `body` describes. `body` runs once, or once for each tag;
/// `definitions` collects the named definitions ($defs).
nlohmann::ordered_json object_schema(const Visitor::Body& body, nlohmann::ordered_json* definitions);

}  // namespace aberfit::internal
