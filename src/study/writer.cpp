#include <nlohmann/json.hpp>

#include "visitor.h"

namespace aberfit::internal {
namespace {

using Json = nlohmann::ordered_json;

class Writer : public Visitor {
 public:
  Json json = Json::object();

  void quantity(const Field& field, std::optional<double>& value, Dimension, Range) override {
    if (value) json[field.key] = *value;
  }
  void quantities(const Field& field, std::vector<double>& values, Dimension, Range, bool) override {
    if (!values.empty()) json[field.key] = values;
  }
  void numbered_quantities(const Field& field, NumberedQuantities& values, int, int, Dimension,
                           Range) override {
    Json items = Json::object();
    for (const auto& [key, value] : values) items[std::to_string(key)] = value;
    json[field.key] = std::move(items);
  }
  void word_or_quantity(const Field& field, WordOrQuantity& value, const std::string&, Dimension,
                        Range) override {
    const auto* word = std::get_if<std::string>(&value);
    if (word && word->empty()) return;
    std::visit([&](const auto& held) { json[field.key] = held; }, value);
  }
  void points(const Field& field, Points& points, std::size_t) override { json[field.key] = points; }
  void integer(const Field& field, std::optional<std::int64_t>& value, std::int64_t, std::int64_t) override {
    if (value) json[field.key] = *value;
  }
  void seed(const Field& field, std::uint64_t& value) override { json[field.key] = value; }
  void boolean(const Field& field, bool& value) override { json[field.key] = value; }
  void text(const Field& field, std::string& value, bool) override {
    if (!value.empty()) json[field.key] = value;
  }
  void texts(const Field& field, Names& values, std::size_t, std::size_t) override {
    if (!values.empty()) json[field.key] = values;
  }
  void texts_by_key(const Field& field, TextsByKey& values, const std::vector<KeyPattern>&,
                    const std::string&) override {
    Json items = Json::object();
    for (const auto& [key, text] : values) items[key] = text;
    if (!items.empty()) json[field.key] = std::move(items);
  }
  void variations(const Field& field, TextsByKey& values) override {
    Json items = Json::object();
    for (const auto& [key, text] : values) items[key] = Json::parse(text);
    json[field.key] = std::move(items);
  }
  void choice(const Field& field, std::size_t& index, const Names& names) override {
    json[field.key] = names.at(index);
  }
  void choices(const Field& field, std::vector<std::size_t>& indices, const Names& names) override {
    Json words = Json::array();
    for (const std::size_t index : indices) words.push_back(names.at(index));
    json[field.key] = words;
  }
  void object(const Field& field, bool* present, const Body& body, const char*) override {
    if (!present || *present) json[field.key] = write_object(body);
  }
  void word_or_object(const Field& field, bool& is_object, const Names& words, std::size_t& word,
                      const Body& body) override {
    json[field.key] = is_object ? write_object(body) : Json(words.at(word));
  }
  void word_or_integer(const Field& field, bool& is_word, const std::string& word, std::int64_t& value,
                       std::int64_t, std::int64_t) override {
    json[field.key] = is_word ? Json(word) : Json(value);
  }
  void list(const Field& field, std::size_t count, std::size_t, const Resize&, const ItemBody& body,
            const char*) override {
    Json items = Json::array();
    for (std::size_t i = 0; i < count; ++i) items.push_back(write_object([&](Visitor& v) { body(v, i); }));
    json[field.key] = std::move(items);
  }
  void keyed(const Field& field, Names& keys, const std::vector<KeyPattern>&, const ItemBody& body) override {
    Json items = Json::object();
    for (std::size_t i = 0; i < keys.size(); ++i)
      items[keys[i]] = write_object([&](Visitor& v) { body(v, i); });
    json[field.key] = std::move(items);
  }
};

}  // namespace

Json write_object(const Visitor::Body& body) {
  Writer writer;
  body(writer);
  return std::move(writer.json);
}

}  // namespace aberfit::internal
