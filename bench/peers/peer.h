#pragma once
#include <string>

#include "contenders/contender.h"

namespace genphys::bench {

/// Another engine, which a program of this folder simulates with.
struct Peer {
  Contender contender;
  std::string about;  // a JSON object: its name, version and settings, as the program tells them
};

/// Starts the peer that `description` tells: its name, an equals sign, and a program with its arguments, separated by
/// blanks. A program that does not answer is a std::runtime_error. It runs as long as a copy of the contender is there,
/// and simulates one scene at a time: a simulation ends when the next one starts.
Peer StartPeer(const std::string& description);

}  // namespace genphys::bench
