#include "gnuplot.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
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
    // Relative entries would mean something else in the folder of the plots.
    if (candidate.is_absolute() && std::filesystem::is_regular_file(candidate, error) &&
        ::access(candidate.c_str(), X_OK) == 0)
      return candidate.string();
    begin = end + 1;
  }
  return "";
}

std::string run_gnuplot(const std::string& gnuplot, const std::string& directory, const std::string& script) {
  std::string option = "--default-settings", program = gnuplot, file = script;  // execv wants them mutable
  const std::array<char*, 4> arguments = {program.data(), option.data(), file.data(), nullptr};
  std::array<int, 2> said{};
  if (::pipe2(said.data(), O_CLOEXEC) != 0) return std::strerror(errno);
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  const pid_t child = ::fork();
  if (child == 0) {
    // Only calls that are safe after fork in a program with threads.
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
  if (child > 0) {
    std::array<char, 4096> buffer;
    for (ssize_t n; (n = ::read(said[0], buffer.data(), buffer.size())) != 0;) {
      if (n > 0) text.append(buffer.data(), std::size_t(n));
      if (n < 0 && errno != EINTR) break;
    }
  }
  ::close(said[0]);
  if (child < 0) return std::strerror(fork_error);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return std::strerror(errno);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  text = one_line(text);
  if (!text.empty()) return text;
  return WIFEXITED(status) ? "it ended with code " + std::to_string(WEXITSTATUS(status))
                           : "it was ended by signal " + std::to_string(WTERMSIG(status));
}

}  // namespace aberfit::internal
