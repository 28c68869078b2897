#include "aberfit/report/html_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <kainjow/mustache.hpp>
#include <map>
#include <nlohmann/json.hpp>

#include "aberfit/core/embedded_texts.h"
#include "aberfit/core/overloaded.h"
#include "aberfit/core/text.h"
#include "aberfit/report/documents.h"
#include "file_purposes.h"
#include "glossary.h"
#include "json_number.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr std::size_t kMostBytes = 3'000'000;  // limit for the whole page

using Filling = kainjow::mustache::data;

// Converts JSON for the template. False, null and empty arrays are absent.
Filling mustache_of(const Json& json) {
  if (json.is_object()) {
    Filling object(Filling::type::object);
    for (const auto& [key, value] : json.items()) object.set(key, mustache_of(value));
    return object;
  }
  if (json.is_array()) {
    Filling list(Filling::type::list);
    for (const Json& item : json) list.push_back(mustache_of(item));
    return list;
  }
  if (json.is_boolean()) return Filling(json.get<bool>());
  if (json.is_null()) return Filling(false);
  if (!json.is_string()) return Filling(json.dump());
  return json.get<std::string>().empty() ? Filling(false) : Filling(json.get<std::string>());
}

std::string rendered(const std::string& name, const Json& context) {
  Filling filling = mustache_of(context);
  filling.set("style", embedded_text("report.css"));
  for (const char* part : {"head", "first", "part"})
    filling.set(part,
                kainjow::mustache::partial([part] { return embedded_text(part + std::string(".html")); }));
  return kainjow::mustache::mustache(embedded_text(name)).render(filling);
}

const char* word_of(Page::Tone tone) {
  constexpr const char* kWords[] = {"", "good", "open", "bad"};
  return kWords[std::size_t(tone)];
}

Json labelled(const std::string& label, const std::string& text) {
  return {{"label", label}, {"text", text}};
}

Json rows_of(const std::vector<Page::Text>& texts) {
  Json rows = Json::array();
  for (const Page::Text& text : texts) rows.push_back(labelled(text.label, text.text));
  return rows;
}

Json table_of(const Page::Table& table) {
  const auto cell = [&](std::size_t k, const std::string& text) -> Json {
    return {{"text", text}, {"side", std::string(1, k < table.align.size() ? table.align[k] : 'l')}};
  };
  Json heads = Json::array(), rows = Json::array();
  for (std::size_t k = 0; k < table.heads.size(); ++k) heads.push_back(cell(k, table.heads[k]));
  for (const Page::Table::Row& row : table.rows) {
    Json one = {{"tone", word_of(row.tone)}, {"columns", table.align.size()}, {"cells", Json::array()}};
    if (row.cells.size() == 1 && table.align.size() > 1) one["group"] = row.cells[0];
    for (std::size_t k = 0; !one.contains("group") && k < row.cells.size(); ++k)
      one["cells"].push_back(cell(k, row.cells[k]));
    rows.push_back(std::move(one));
  }
  return {{"title", table.title},
          {"has_heads", !heads.empty()},
          {"heads", heads},
          {"rows", rows},
          {"note", table.note}};
}

// Adjacent paragraphs become one list.
Json parts_of(const std::vector<Page::Part>& parts) {
  Json all = Json::array();
  for (const Page::Part& part : parts)
    std::visit(
        Overloaded{[&](const Page::Text& text) {
                     if (all.empty() || !all.back().contains("texts"))
                       all.push_back({{"texts", {{"rows", Json::array()}}}});
                     all.back()["texts"]["rows"].push_back(labelled(text.label, text.text));
                   },
                   [&](const Page::Table& table) {
                     all.push_back({{"table", table_of(table)}});
                   },
                   [&](const Page::Verbatim& verbatim) {
                     all.push_back({{"verbatim", {{"title", verbatim.title}, {"text", verbatim.text}}}});
                   }},
        part);
  return all;
}

// A block of a study in words with the typed units: "focal length 2.8 m, conic -1".
std::string words_of(const Json& node) {
  if (node.is_string()) return node.get<std::string>();
  std::string text;
  const auto join = [&](const std::string& one) { text += (text.empty() ? "" : ", ") + one; };
  if (node.is_array())
    for (const Json& item : node) join(item.is_object() ? "(" + words_of(item) + ")" : words_of(item));
  if (!node.is_object()) return node.is_array() ? text : node.dump();
  for (const auto& [key, value] : node.items()) {
    std::string name = key;
    std::replace(name.begin(), name.end(), '_', ' ');
    if (value.is_structured() && value.empty())
      join(name);
    else
      join(name + " " + (value.is_object() ? "(" + words_of(value) + ")" : words_of(value)));
  }
  return text;
}

Json asked_of(const Json& study) {
  Json rows = Json::array();
  for (const auto& [key, value] : study.items())
    if (key != "aberfit" && key != "title" && key != "description" && key != "$schema" && key != "output")
      rows.push_back(labelled(key, words_of(value)));
  return rows;
}

std::string base64(const std::string& bytes) {
  static const char* const kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

// The subcommand that makes a kind of result.
std::string command_of(const std::string& kind) {
  if (kind == "ceilings" || kind == "psd-of-focus") return "solve";
  return kind == "check-of-map" ? "check" : kind;
}

// "Result of aberfit fit, version 1.0.0, of 2026-01-02 10:00:00 UTC, on AMD EPYC, 2 threads".
std::string made_by(const std::string& kind, const Json& provenance, const std::vector<Page::Text>& run) {
  std::string text =
      fmt::format("Result of aberfit {}, version {}", command_of(kind), provenance.value("version", ""));
  for (const Page::Text& one : run) {
    if (one.label == "date") text += ", of " + one.text;
    if (one.label == "machine") text += ", on " + one.text;
  }
  return text;
}

// The drawing alone, because a page must not contain an XML declaration.
std::string svg_of(const std::string& file) {
  const std::size_t begin = file.find("<svg");
  return begin == std::string::npos ? "" : file.substr(begin);
}

Json pictures_of(const HtmlReport& report, std::size_t room) {
  Json all = Json::array();
  for (const DrawnPicture& picture : report.pictures) {
    Json one = {{"title", picture.title}, {"caption", picture.caption}, {"alt", picture.alt}};
    const std::string bytes = file_bytes(report.folder + "/" + picture.file).value_or("");
    const bool png = picture.file.ends_with(".png");
    const std::string shown = picture.file.ends_with(".svg") ? svg_of(bytes) : png ? base64(bytes) : "";
    if (!shown.empty() && shown.size() <= room) {
      one[png ? "png" : "svg"] = shown;
      room -= shown.size();
    } else {
      one["elsewhere"] = "See the file " + picture.file + ".";
    }
    all.push_back(std::move(one));
  }
  return all;
}

std::string shown_number(const Json& value) {
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  return value.is_string() ? value.get<std::string>() : value.is_null() ? "-" : value.dump();
}

// Adds every single number of a document with unit and meaning from the schema. Lists give their length.
void add_numbers(const Json& value, const Json& schema, const std::string& key, Json* rows) {
  const Json& own = schema.contains("anyOf") ? schema["anyOf"][0] : schema;
  const Json* members = own.contains("properties") ? &own["properties"] : nullptr;
  const auto row = [&](const std::string& text) {
    rows->push_back({{"key", key},
                     {"value", text},
                     {"unit", schema.value("unit", "")},
                     {"meaning", schema.value("description", "")}});
  };
  if (value.is_object() && members) {
    for (const auto& [name, inner] : value.items())
      if (name != "study" && name != "request" && members->contains(name))
        add_numbers(inner, (*members)[name], key.empty() ? name : key + "." + name, rows);
  } else if (value.is_structured()) {
    row(fmt::format("{} entries", value.size()));
  } else {
    row(shown_number(value));
  }
}

Json numbers_of(const Json& document) {
  Json rows = Json::array();
  const Json schema = results_schema();
  for (const Json& one : schema["oneOf"])
    if (one["properties"]["kind"]["const"] == document["kind"]) add_numbers(document, one, "", &rows);
  return rows;
}

Json provenance_of(const Json& document, const std::vector<Page::Text>& run) {
  Json rows = rows_of(run);
  const Json& from = document.contains("provenance") ? document["provenance"] : Json::object();
  const auto add = [&](const char* label, const char* key) {
    if (from.contains(key) && !from[key].is_null()) rows.push_back(labelled(label, shown_number(from[key])));
  };
  add("aberfit", "version");
  add("commit", "commit");
  add("seed", "seed");
  add("threads", "threads");
  for (const Json& input : from.value("inputs", Json::array()))
    rows.push_back(labelled("SHA-256 of " + input["file"].get<std::string>(), input["sha256"]));
  const Json libraries = from.value("libraries", Json::object());
  if (!libraries.empty()) rows.push_back(labelled("libraries", words_of(libraries)));
  return rows;
}

Json named(const std::vector<NamedPurpose>& all, const char* name, const char* purpose) {
  Json list = Json::array();
  for (const NamedPurpose& one : all) list.push_back({{name, one.name}, {purpose, one.purpose}});
  return list;
}

// Values of one key in several results, in their order; "-" if a result has none.
struct Compared {
  std::string unit, meaning;
  std::vector<std::string> values;
};

// The rows whose values differ between results.
Json differing(const std::vector<Json>& of_results) {
  std::vector<std::string> order;
  std::map<std::string, Compared> all;
  for (std::size_t k = 0; k < of_results.size(); ++k)
    for (const Json& row : of_results[k]) {
      const std::string key = row["key"];
      if (!all.contains(key)) {
        order.push_back(key);
        all[key] = {row["unit"], row["meaning"], std::vector<std::string>(of_results.size(), "-")};
      }
      all[key].values[k] = row["value"];
    }
  Json rows = Json::array();
  for (const std::string& key : order) {
    const Compared& one = all[key];
    if (std::adjacent_find(one.values.begin(), one.values.end(), std::not_equal_to<>()) != one.values.end())
      rows.push_back({{"key", key}, {"values", one.values}, {"unit", one.unit}, {"meaning", one.meaning}});
  }
  return rows;
}

// Every value of a study with its pointer.
Json flattened(const Json& study) {
  Json rows = Json::array();
  const Json flat = study.flatten();
  for (const auto& [pointer, value] : flat.items())
    rows.push_back({{"key", pointer}, {"value", shown_number(value)}, {"unit", ""}, {"meaning", ""}});
  return rows;
}

// Rows that at least two results have, or those that only one has.
Json shared_rows(const Json& rows, bool shared) {
  Json some = Json::array();
  for (const Json& row : rows) {
    const auto have = std::count_if(row["values"].begin(), row["values"].end(),
                                    [](const Json& value) { return value != "-"; });
    if (row["key"] != "headline" && (have > 1) == shared) some.push_back(row);
  }
  return some;
}

// Title, program and inputs of each result, one row per label.
Json origins_of(const std::vector<ComparedResult>& results) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<std::string>> all;
  for (std::size_t k = 0; k < results.size(); ++k) {
    const Json& document = results[k].document;
    const auto add = [&](const std::string& label, const std::string& value) {
      if (!all.contains(label)) {
        order.push_back(label);
        all[label] = std::vector<std::string>(results.size(), "-");
      }
      all[label][k] = value;
    };
    add("study", document.value("study", Json::object()).value("title", ""));
    add("command", "aberfit " + command_of(document.value("kind", "")));
    for (const Json& row : provenance_of(document, {})) add(row["label"], row["text"]);
  }
  Json rows = Json::array();
  for (const std::string& label : order) rows.push_back({{"label", label}, {"values", all[label]}});
  return rows;
}

// The mirror, its light and its roughness, where all results have the same.
Json common_of(const std::vector<ComparedResult>& results) {
  Json rows = Json::array();
  for (const char* key : {"mirror", "aperture", "light", "roughness"}) {
    const auto block = [key](const ComparedResult& one) {
      return one.document.value("study", Json::object()).value(key, Json());
    };
    const bool same = !results.empty() && !block(results.front()).is_null() &&
                      std::all_of(results.begin(), results.end(), [&](const ComparedResult& one) {
                        return block(one) == block(results.front());
                      });
    if (same) rows.push_back(labelled(key, words_of(block(results.front()))));
  }
  return rows;
}

// The answer, the question, the limits and the tables.
Json first_of(const HtmlReport& report) {
  const Page& page = report.page;
  const std::string kind = report.document["kind"];
  const Json asked = asked_of(report.asked);
  Json warnings = Json::array();
  for (const Warning& warning : page.warnings)
    warnings.push_back({{"code", warning.code}, {"message", warning.message}});
  return {{"heading", page.title.empty() ? "aberfit " + kind : page.title},
          {"headline", page.headline},
          {"tone", word_of(page.tone)},
          {"advice", page.advice},
          {"has_asked", !asked.empty()},
          {"asked", asked},
          {"has_answers", !page.answers.empty()},
          {"answers", rows_of(page.answers)},
          {"has_warnings", !warnings.empty()},
          {"warnings", warnings},
          {"parts", parts_of(page.parts)}};
}

}  // namespace

std::string html_of(const std::vector<ComparedResult>& results, const std::vector<Page::Text>& run) {
  Json listed = Json::array(), names = Json::array();
  std::vector<Json> asked, numbers;
  for (const ComparedResult& one : results) {
    names.push_back(one.name);
    const std::string headline = one.document.value("headline", "");
    listed.push_back(
        {{"name", one.name},
         {"text",
          headline.empty() ? "Result of `aberfit " + one.document.value("kind", "") + "`." : headline},
         {"link", one.link}});
    asked.push_back(flattened(one.document.value("study", Json::object())));
    numbers.push_back(numbers_of(one.document));
  }
  const Json differing_asked = differing(asked), differing_numbers = differing(numbers);
  const Json common = common_of(results), single = shared_rows(differing_numbers, false);
  const Json words =
      named(words_in(listed.dump(-1, ' ', false, Json::error_handler_t::replace)), "label", "text");
  const Json context = {{"heading", fmt::format("{} results side by side", results.size())},
                        {"results", listed},
                        {"names", names},
                        {"has_asked", !differing_asked.empty()},
                        {"asked", differing_asked},
                        {"has_common", !common.empty()},
                        {"common", common},
                        {"origins", origins_of(results)},
                        {"has_words", !words.empty()},
                        {"words", words},
                        {"run", rows_of(run)},
                        {"numbers", shared_rows(differing_numbers, true)},
                        {"has_single", !single.empty()},
                        {"single", single}};
  return rendered("compare.html", context);
}

std::string first_screen_of(const HtmlReport& report) { return rendered("first.html", first_of(report)); }

std::string html_of(const HtmlReport& report) {
  const Json from = report.document.value("provenance", Json::object());
  Json uses = named(uses_of_terms(report.folder), "label", "text"), whole = Json::array();
  if (report.whole)
    for (const Json& part : parts_of(report.whole->parts))
      if (part.contains("table")) whole.push_back(part);
  Json context = first_of(report);
  context.update({{"made", made_by(report.document["kind"], from, report.run)},
                  {"description", report.asked.value("description", "")},
                  {"has_whole", !whole.empty()},
                  {"whole", whole},
                  {"has_uses", !uses.empty()},
                  {"uses", uses},
                  {"files", named(files_with_purpose(report.folder), "name", "purpose")},
                  {"provenance", provenance_of(report.document, report.run)},
                  {"numbers", numbers_of(report.document)}});
  std::string said;
  for (const char* part : {"headline", "advice", "asked", "answers", "warnings", "parts"})
    said += context[part].dump(-1, ' ', false, Json::error_handler_t::replace);
  const Json words = named(words_in(said), "label", "text");
  context["has_words"] = !words.empty();
  context["words"] = words;
  const std::size_t without = context.dump(-1, ' ', false, Json::error_handler_t::replace).size() * 2;
  const Json pictures = pictures_of(report, kMostBytes - std::min(kMostBytes, without));
  context["has_pictures"] = !pictures.empty();
  context["pictures"] = pictures;
  return rendered("report.html", context);
}

}  // namespace aberfit
