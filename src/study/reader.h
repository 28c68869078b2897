#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "visitor.h"

namespace aberfit::internal {

/// Fills the described structures from JSON, strictly: unknown keys, wrong types, missing keys, bad units and
/// values out of range throw InputError with the JSON pointer.
class Reader : public Visitor {
 public:
  using Json = nlohmann::ordered_json;
  /// `json` and `file` must outlive the reader; `pointer` is where `json` stands in the file.
  Reader(const Json& json, const std::string& file, std::string pointer)
      : json_(json), file_(file), pointer_(std::move(pointer)) {}

  /// Checks that json is an object with known keys only, then lets the body read it.
  void read_object(const Body& body, const char* note = nullptr);

  using Visitor::integer;
  using Visitor::quantity;
  void quantity(const Field&, std::optional<double>&, Dimension, Range) override;
  void quantities(const Field&, std::vector<double>&, Dimension, Range, bool ascending) override;
  void numbered_quantities(const Field&, std::map<int, double>&, int low, int high, Dimension,
                           Range) override;
  void word_or_quantity(const Field&, std::variant<std::string, double>&, const std::string& regex, Dimension,
                        Range) override;
  void points(const Field&, std::vector<std::array<double, 2>>&, std::size_t least) override;
  void integer(const Field&, std::optional<std::int64_t>&, std::int64_t low, std::int64_t high) override;
  void seed(const Field&, std::uint64_t&) override;
  void boolean(const Field&, bool&) override;
  void text(const Field&, std::string&, bool may_be_empty) override;
  void choice(const Field&, std::size_t& index, const std::vector<std::string>& names) override;
  void choices(const Field&, std::vector<std::size_t>& indices,
               const std::vector<std::string>& names) override;
  void tag(const Field&, std::size_t& index, const std::vector<std::string>& names) override;
  void object(const Field&, bool* present, const Body&, const char* definition) override;
  void word_or_object(const Field&, bool& is_object, const std::string& word, const Body&) override;
  void word_or_integer(const Field&, bool& is_word, const std::string& word, std::int64_t&, std::int64_t low,
                       std::int64_t high) override;
  void list(const Field&, std::size_t count, std::size_t least,
            const std::function<void(std::size_t)>& resize,
            const std::function<void(Visitor&, std::size_t)>& body, const char* definition) override;
  void keyed(const Field&, std::vector<std::string>& keys, const std::vector<KeyPattern>&,
             const std::function<void(Visitor&, std::size_t)>& body) override;
  void removed_word(const char* key, const char* word, const char* why, const char* instead) override;
  void check(bool holds, const std::string& key, const std::string& found,
             const std::string& allowed) override;
  bool reading() const override { return true; }

 private:
  class KnownKeys;

  /// The value of the key, null pointer when an optional one is absent. Throws when a required one is.
  const Json* find(const Field& field) const;
  [[noreturn]] void fail(const std::string& pointer, const std::string& found,
                         const std::string& allowed) const;
  [[noreturn]] void fail(const std::string& pointer, const Json& found, const std::string& allowed,
                         const Field& field) const;
  double number(const Json& json, const std::string& pointer, const Field&, Dimension, Range) const;
  std::string at(const Field& field) const;
  Reader inside(const Json& json, const std::string& pointer) const { return Reader(json, file_, pointer); }

  const Json& json_;
  const std::string& file_;
  std::string pointer_;
};

/// The candidate with the smallest edit distance (Levenshtein, case folded) to `word`; empty when none is
/// near (more than half of the word changed).
std::string nearest(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace aberfit::internal
