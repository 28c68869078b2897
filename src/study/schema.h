#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "visitor.h"

namespace aberfit::internal {

/// Documents what is described as JSON Schema, draft 2020-12. One object: `object_schema` runs its body once,
/// or once per tag.
class SchemaWriter : public Visitor {
 public:
  using Json = nlohmann::ordered_json;

  /// Schema of the object that `body` describes; `definitions` collects the named ones ($defs).
  static Json object_schema(const Body& body, Json* definitions);

  using Visitor::integer;
  using Visitor::quantity;
  void quantity(const Field& field, std::optional<double>& value, Dimension, Range) override;
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

 private:
  explicit SchemaWriter(Json* definitions) : definitions_(definitions) {}

  void add(const Field& field, Json schema);
  Json named_object(const Body& body, const char* definition);

  Json* definitions_;
  Json properties_ = Json::object();
  Json required_ = Json::array();
  std::size_t tag_index_ = 0;  // which alternative of a tagged object is being described
  std::size_t tag_count_ = 0;  // how many there are; 0: not tagged
};

}  // namespace aberfit::internal
