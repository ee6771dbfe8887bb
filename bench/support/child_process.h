#pragma once
#include <sys/types.h>

#include <string>
#include <string_view>
#include <vector>

namespace genphys::bench {

/// A program that this one started, spoken to through its standard input and output. It is ended with this object.
/// Every failure is a std::runtime_error.
class ChildProcess {
 public:
  explicit ChildProcess(std::vector<std::string> arguments);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  void Write(std::string_view bytes);
  /// The next line without its end. It is an error if there is none.
  std::string ReadLine();
  /// Processor time of all its threads so far, in seconds.
  double cpu_time() const;

 private:
  std::string program_;
  pid_t pid_ = -1;
  int input_ = -1;
  int output_ = -1;
  std::string received_;
};

}  // namespace genphys::bench
