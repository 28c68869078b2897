#include "writer.h"

namespace aberfit::internal {

void Writer::quantity(const Field& field, std::optional<double>& value, Dimension, Range) {
  if (value) json[field.key] = *value;
}

void Writer::quantities(const Field& field, std::vector<double>& values, Dimension, Range, bool) {
  if (!values.empty()) json[field.key] = values;
}

void Writer::numbered_quantities(const Field& field, std::map<int, double>& values, int, int, Dimension,
                                 Range) {
  Json items = Json::object();
  for (const auto& [key, value] : values) items[std::to_string(key)] = value;
  json[field.key] = std::move(items);
}

void Writer::word_or_quantity(const Field& field, std::variant<std::string, double>& value,
                              const std::string&, Dimension, Range) {
  std::visit([&](const auto& held) { json[field.key] = held; }, value);
}

void Writer::points(const Field& field, std::vector<std::array<double, 2>>& points, std::size_t) {
  json[field.key] = points;
}

void Writer::integer(const Field& field, std::optional<std::int64_t>& value, std::int64_t, std::int64_t) {
  if (value) json[field.key] = *value;
}

void Writer::seed(const Field& field, std::uint64_t& value) { json[field.key] = value; }

void Writer::boolean(const Field& field, bool& value) { json[field.key] = value; }

void Writer::text(const Field& field, std::string& value, bool) {
  if (!value.empty()) json[field.key] = value;
}

void Writer::choice(const Field& field, std::size_t& index, const std::vector<std::string>& names) {
  json[field.key] = names.at(index);
}

void Writer::choices(const Field& field, std::vector<std::size_t>& indices,
                     const std::vector<std::string>& names) {
  Json words = Json::array();
  for (const std::size_t index : indices) words.push_back(names.at(index));
  json[field.key] = words;
}

void Writer::tag(const Field& field, std::size_t& index, const std::vector<std::string>& names) {
  choice(field, index, names);
}

void Writer::object(const Field& field, bool* present, const Body& body, const char*) {
  if (present && !*present) return;
  Writer inside;
  body(inside);
  json[field.key] = std::move(inside.json);
}

void Writer::word_or_object(const Field& field, bool& is_object, const std::string& word, const Body& body) {
  if (is_object)
    object(field, nullptr, body, nullptr);
  else
    json[field.key] = word;
}

void Writer::word_or_integer(const Field& field, bool& is_word, const std::string& word, std::int64_t& value,
                             std::int64_t, std::int64_t) {
  if (is_word)
    json[field.key] = word;
  else
    json[field.key] = value;
}

void Writer::list(const Field& field, std::size_t count, std::size_t, const std::function<void(std::size_t)>&,
                  const std::function<void(Visitor&, std::size_t)>& body, const char*) {
  Json items = Json::array();
  for (std::size_t i = 0; i < count; ++i) {
    Writer inside;
    body(inside, i);
    items.push_back(std::move(inside.json));
  }
  json[field.key] = std::move(items);
}

void Writer::keyed(const Field& field, std::vector<std::string>& keys, const std::vector<KeyPattern>&,
                   const std::function<void(Visitor&, std::size_t)>& body) {
  Json items = Json::object();
  for (std::size_t i = 0; i < keys.size(); ++i) {
    Writer inside;
    body(inside, i);
    items[keys[i]] = std::move(inside.json);
  }
  json[field.key] = std::move(items);
}

}  // namespace aberfit::internal
