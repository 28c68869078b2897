#pragma once

namespace aberfit::internal {

/// While it lives, the first SIGINT or SIGTERM only asks to come to an end; one that comes a second later or
/// more ends the process.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  bool asked() const;

 private:
  void (*before_int_)(int);
  void (*before_term_)(int);
};

}  // namespace aberfit::internal
