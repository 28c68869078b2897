#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "visitor.h"

namespace aberfit::internal {

/// Writes the described structures as JSON with every value that they hold, quantities as plain SI numbers.
class Writer : public Visitor {
 public:
  using Json = nlohmann::ordered_json;
  Json json = Json::object();

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
};

}  // namespace aberfit::internal
