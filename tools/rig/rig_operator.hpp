// Who tells the controller what to do: a thread of its own, since answers may take their time or never come.
#pragma once

#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "tools/rig/rig_scenario.hpp"

namespace vergence::rig {

class RigOperator {
 public:
  // At the scenario's times after start_ns, by the controller's socket. What was said and answered is kept.
  RigOperator(std::string socket, const RigScenario& scenario, std::int64_t start_ns);

  // Waits for its end, at the latest at that of the scenario.
  [[nodiscard]] const std::vector<std::string>& finish();

 private:
  void work(const std::stop_token& stop);
  void be_patient(double t_s);
  std::string say(double t_s, const std::string& word);

  std::string socket_;
  RigScenario scenario_;
  std::int64_t start_ns_;
  bool servoed_ = false;
  std::string last_;
  std::vector<std::string> conversation_;
  std::jthread thread_;
};

}  // namespace vergence::rig
