#include "aberfit/commands/serve.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <iostream>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "aberfit/commands/answer.h"
#include "aberfit/commands/program.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/report/documents.h"
#include "aberfit/study/parse_json.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

using Json = nlohmann::ordered_json;

struct Request {
  Json id;  // as the client gave it; null if it gave none
  Json content;
  std::atomic<bool> cancelled{false};
};

// Lines of answers from several threads.
class Answers {
 public:
  explicit Answers(std::ostream& out) : out_(out) {}
  void send(const Json& line) {
    const std::string text = line.dump(-1, ' ', false, Json::error_handler_t::replace);
    const std::lock_guard lock(mutex_);
    out_ << text << '\n' << std::flush;
  }
  void fail(const Json& id, const std::string& kind, const std::string& message,
            Json where = Json::object()) {
    where["kind"] = kind;
    where["message"] = message;
    send({{"id", id}, {"error", where}});
  }

 private:
  std::ostream& out_;
  std::mutex mutex_;
};

[[noreturn]] void refuse(const std::string& pointer, const std::string& found, const std::string& allowed) {
  throw InputError("request", pointer, found, allowed);
}

std::vector<std::string> methods() {
  std::vector<std::string> names = study_command_names();
  for (const char* name : {"schema", "cancel"}) names.emplace_back(name);
  return names;
}

std::string text_of(const Json& content, const char* key) {
  if (!content.contains(key)) return {};
  if (!content[key].is_string()) refuse(std::string("/") + key, content[key].dump(), "a text");
  return content[key];
}

// Throws InputError for a key that no request has.
void require_known_keys(const Json& content) {
  static const std::vector<std::string> kKeys = {"id", "method", "study", "file", "set", "output", "of"};
  for (const auto& [key, value] : content.items())
    if (std::find(kKeys.begin(), kKeys.end(), key) == kKeys.end())
      refuse(child_pointer("", key), "an unknown key", fmt::format("{}", fmt::join(kKeys, ", ")));
}

// The study of a request: a block `study`, or the path of a file; with the values of `set`.
std::shared_ptr<const Study> study_of(const Json& content) {
  std::vector<std::string> changes;
  if (content.contains("set") && !content["set"].is_object())
    refuse("/set", content["set"].dump(), R"(an object, {"/json/pointer": value})");
  if (content.contains("set"))
    for (const auto& [pointer, value] : content["set"].items())
      changes.push_back(pointer + "=" + value.dump());
  if (content.contains("study") && content.contains("file"))
    refuse("/file", "a file beside a study", "one of the two");
  if (content.contains("study"))
    return std::make_shared<const Study>(parse_study(content["study"].dump(), "request", changes));
  const std::string file = text_of(content, "file");
  if (file.empty())
    refuse("/study", kMissing, "a request needs a block \"study\", or \"file\" with its path");
  return std::make_shared<const Study>(read_study(file, changes));
}

Json schema_of(const Json& content) {
  const std::string of = text_of(content, "of");
  if (!of.empty() && of != "study" && of != "results")
    refuse("/of", '"' + of + '"', R"("study" or "results")");
  return of == "results" ? results_schema() : study_schema();
}

void run(Request& request, int threads, Answers* answers) {
  const Json& content = request.content;
  require_known_keys(content);
  const std::string method = text_of(content, "method");
  const std::vector<std::string>& commands = study_command_names();
  if (method == "schema") return answers->send({{"id", request.id}, {"result", schema_of(content)}});
  const auto command = std::find(commands.begin(), commands.end(), method);
  if (command == commands.end())
    refuse("/method", method.empty() ? kMissing : '"' + method + '"',
           fmt::format("one of {}", fmt::join(methods(), ", ")));
  RunOptions options;
  options.threads = threads;
  options.output_directory = text_of(content, "output");
  options.command_line = "aberfit serve: " + method;
  options.interrupted = [&] { return request.cancelled.load(); };
  options.stopped_by = [] { return std::string("a request to cancel it"); };
  options.progress = [&](const std::string& line) {
    answers->send({{"id", request.id}, {"progress", line}});
  };
  const Answer found = answer(StudyCommand(command - commands.begin()), *study_of(content), options);
  answers->send({{"id", request.id},
                 {"exit_code", int(found.code)},
                 {"text", text_of(found.page)},
                 {"result", found.document()}});
}

// Does a part of the work for a request. What that throws becomes the answer.
void answer_or_fail(const Request& request, Answers* answers, const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    answers->fail(request.id, "input", error.what(),
                  {{"file", error.file()},
                   {"pointer", error.pointer()},
                   {"found", error.found()},
                   {"allowed", error.allowed()}});
  } catch (const FieldError& error) {
    answers->fail(request.id, "input", error.what(),
                  {{"pointer", error.field()}, {"found", error.found()}, {"allowed", error.allowed()}});
  } catch (const Interrupted& error) {
    answers->fail(request.id, "cancelled", error.what());
  } catch (const std::bad_alloc&) {
    answers->fail(request.id, "computation", "not enough memory");
  } catch (const std::exception& error) {
    answers->fail(request.id, "computation", error.what());
  }
}

// Requests that wait, and the one that runs.
class Requests {
 public:
  void add(std::shared_ptr<Request> request) {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(request));
    changed_.notify_one();
  }
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_one();
  }
  /// Returns whether a request has this id.
  bool cancel(const Json& id) {
    const std::lock_guard lock(mutex_);
    bool found = running_ && running_->id == id;
    if (found) running_->cancelled = true;
    for (const auto& request : waiting_)
      if (request->id == id) request->cancelled = found = true;
    return found;
  }
  /// The next request; null after the last.
  std::shared_ptr<Request> next() {
    std::unique_lock lock(mutex_);
    running_ = nullptr;
    changed_.wait(lock, [&] { return closed_ || !waiting_.empty(); });
    if (waiting_.empty()) return nullptr;
    running_ = waiting_.front();
    waiting_.pop_front();
    return running_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::shared_ptr<Request>> waiting_;
  std::shared_ptr<Request> running_;
  bool closed_ = false;
};

}  // namespace

void serve(std::istream& in, std::ostream& out, int threads) {
  Answers answers(out);
  Requests requests;
  std::thread worker([&] {
    while (const std::shared_ptr<Request> request = requests.next())
      answer_or_fail(*request, &answers, [&] {
        if (request->cancelled) throw Interrupted("cancelled before it began");
        run(*request, threads, &answers);
      });
  });
  for (std::string line; std::getline(in, line);) {
    if (trimmed(line).empty()) continue;
    const auto request = std::make_shared<Request>();
    answer_or_fail(*request, &answers, [&] {
      request->content = parse_json(line, "request");
      if (!request->content.is_object()) refuse("", "no object", "one JSON object a line");
      request->id = request->content.value("id", Json());
      if (text_of(request->content, "method") != "cancel") return requests.add(request);
      if (!request->content.contains("of")) refuse("/of", kMissing, "the id of the request to end");
      answers.send(
          {{"id", request->id}, {"result", {{"cancelled", requests.cancel(request->content["of"])}}}});
    });
  }
  requests.close();
  worker.join();
}

ExitCode serve_command(CommandLine line) {
  serve(std::cin, std::cout, line.threads);
  return ExitCode::kDone;
}

}  // namespace aberfit
