#include "aberfit/report/documents.h"

#include "facts.h"

namespace aberfit {
using namespace internal;

namespace {

template <typename Part>
Json document(const std::string& kind, const Json& study, const std::string& headline, const Part& part,
              const std::optional<Provenance>& provenance) {
  Facts facts(Facts::View::kValues);
  describe_document(facts, kind, study, headline, part, provenance);
  return facts.done();
}

template <typename Part>
Json schema(const std::string& kind) {
  Facts facts(Facts::View::kSchema);
  describe_document(facts, kind, Json(), "", Part(), std::optional<Provenance>());
  Json schema = facts.done();
  schema["title"] = kind;
  return schema;
}

}  // namespace

Json to_json(const ResultDocument& result, const Json& study) {
  return document("fit", study, page_of(result, false).headline, result, result.provenance);
}
Json to_json(const CheckReport& report, const Json& study, const Provenance& provenance) {
  return document("check", study, page_of(report).headline, report, provenance);
}
Json to_json(const MapCheckReport& report, const Json& study, const Provenance& provenance) {
  return document("check-of-map", study, page_of(report).headline, report, provenance);
}
Json to_json(const TraceReport& report, const Json& study, const Provenance& provenance) {
  return document("trace", study, page_of(report).headline, report, provenance);
}
Json to_json(const VerifyReport& report, const Json& study, const Provenance& provenance) {
  return document("verify", study, page_of(report).headline, report, provenance);
}
Json to_json(const Specification& spec, const Json& study, const Provenance& provenance) {
  return document("solve", study, page_of(spec).headline, spec, provenance);
}
Json to_json(const Ceilings& ceilings, const Json& study, const Provenance& provenance) {
  return document("ceilings", study, page_of(ceilings).headline, ceilings, provenance);
}
Json to_json(const PsdOfFocus& result, const Json& study, const Provenance& provenance) {
  return document("psd-of-focus", study, page_of(result).headline, result, provenance);
}
Json to_json(const SweepReport& report, const Json& study, const Provenance& provenance) {
  return document("sweep", study, page_of(report).headline, report, provenance);
}
Json to_json(const Chart& chart, const Json& study, const Provenance& provenance) {
  return document("chart", study, page_of(chart).headline, chart, provenance);
}
Json to_json(const PsdReport& report, const Json& request, const Json& roughness) {
  return facts_of(PsdFacts{&report, request, roughness});
}

Json results_schema() {
  Json psd = schema_of<PsdFacts>();
  psd["title"] = "psd";
  return {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
          {"title", "results of aberfit"},
          {"oneOf",
           {schema<ResultDocument>("fit"), schema<CheckReport>("check"),
            schema<MapCheckReport>("check-of-map"), schema<TraceReport>("trace"),
            schema<VerifyReport>("verify"), schema<Specification>("solve"), schema<Ceilings>("ceilings"),
            schema<PsdOfFocus>("psd-of-focus"), schema<SweepReport>("sweep"), schema<Chart>("chart"), psd}}};
}

}  // namespace aberfit
