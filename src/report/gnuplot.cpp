#include "gnuplot.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace aberfit::internal {
namespace {

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' '; }, ' ');
  const std::size_t begin = text.find_first_not_of(' ');
  if (begin == std::string::npos) return "";
  text = text.substr(begin, text.find_last_not_of(' ') - begin + 1);
  constexpr std::size_t kEnough = 300;
  return text.size() > kEnough ? text.substr(0, kEnough) + " ..." : text;
}

}  // namespace

std::string find_gnuplot() {
  const char* variable = std::getenv("PATH");
  const std::string path = variable ? variable : "";
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find(':', begin), path.size());
    const std::filesystem::path candidate =
        std::filesystem::path(path.substr(begin, end - begin)) / "gnuplot";
    std::error_code error;
    // We skip relative entries, which mean another folder in that of the plots.
    if (candidate.is_absolute() && std::filesystem::is_regular_file(candidate, error) &&
        ::access(candidate.c_str(), X_OK) == 0)
      return candidate.string();
    begin = end + 1;
  }
  return "";
}

namespace {

// Reads the output, of which only the beginning is kept. False if it has not ended after `longest`.
bool read_all(int from, std::chrono::seconds longest, std::string* text) {
  constexpr std::size_t kKept = 1 << 16;
  const auto last = std::chrono::steady_clock::now() + longest;
  std::array<char, 4096> buffer;
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(last - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd ready{from, POLLIN, 0};
    if (::poll(&ready, 1, int(left.count())) <= 0) continue;  // a signal or a timeout
    const ssize_t count = ::read(from, buffer.data(), buffer.size());
    if (count == 0) return true;
    if (count < 0 && errno != EINTR) return true;
    if (count > 0 && text->size() < kKept) text->append(buffer.data(), std::size_t(count));
  }
}

}  // namespace

std::string run_gnuplot(const std::string& gnuplot, const std::string& directory, const std::string& script,
                        std::chrono::seconds longest) {
  std::string option = "--default-settings", program = gnuplot, file = script;  // execv needs mutable texts
  const std::array<char*, 4> arguments = {program.data(), option.data(), file.data(), nullptr};
  std::array<int, 2> said{};
  if (::pipe2(said.data(), O_CLOEXEC) != 0) return std::strerror(errno);
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  const pid_t child = ::fork();
  if (child == 0) {
    // Only these calls are safe after fork in a program with threads.
    if (nothing >= 0) ::dup2(nothing, STDIN_FILENO);
    ::dup2(said[1], STDOUT_FILENO);
    ::dup2(said[1], STDERR_FILENO);
    if (::chdir(directory.c_str()) == 0) ::execv(gnuplot.c_str(), arguments.data());
    ::_exit(127);
  }
  const int fork_error = errno;
  ::close(said[1]);
  if (nothing >= 0) ::close(nothing);
  std::string text;
  const bool ended = child < 0 || read_all(said[0], longest, &text);
  if (!ended) ::kill(child, SIGKILL);
  ::close(said[0]);
  if (child < 0) return std::strerror(fork_error);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return std::strerror(errno);
  if (!ended) return "it did not end within " + std::to_string(longest.count()) + " s";
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  text = one_line(text);
  if (!text.empty()) return text;
  return WIFEXITED(status) ? "it ended with code " + std::to_string(WEXITSTATUS(status))
                           : "it was ended by signal " + std::to_string(WTERMSIG(status));
}

}  // namespace aberfit::internal
