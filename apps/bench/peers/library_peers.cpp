#include "apps/bench/peers/library_peers.h"

namespace tribotrack::bench::peers {

using namespace model;

std::vector<BenchPeer> all_peers() {
  std::vector<BenchPeer> peers;
  [[maybe_unused]] const auto add = [&](std::vector<BenchPeer> more) {
    for (BenchPeer& peer : more) peers.push_back(std::move(peer));
  };
#ifdef TRIBOTRACK_HAS_ODEINT
  add(odeint_peers());
#endif
#ifdef TRIBOTRACK_HAS_CVODE
  add(cvode_peers());
#endif
  return peers;
}

std::vector<std::string> missing_libraries() {
  std::vector<std::string> missing;
#ifndef TRIBOTRACK_HAS_ODEINT
  missing.emplace_back("Boost.odeint");
#endif
#ifndef TRIBOTRACK_HAS_CVODE
  missing.emplace_back("SUNDIALS");
#endif
  return missing;
}

}  // namespace tribotrack::bench::peers
