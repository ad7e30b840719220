#include "tools/bringup/table.hpp"

#include <gtest/gtest.h>

namespace vergence::tools {
namespace {

TEST(BringupTable, SaysOnceWhyManyChecksWereSkipped) {
  Findings can("can");
  can.fail("interface", "can0 is not there", "plug the adapter in");
  for (const char* const check : {"bit rate", "bus state", "traffic"}) can.skip(check, "no interface");
  can.skip("no other master", "nothing was heard");
  can.skip("no other nodes", "nothing was heard");
  can.pass("axis 1", "");
  EXPECT_EQ(table_of(can.take()),
            "can      interface                  FAIL     can0 is not there\n"
            "         -> plug the adapter in\n"
            "can      3 checks                   skipped  bit rate to traffic: no interface\n"
            "can      no other master            skipped  nothing was heard\n"
            "can      no other nodes             skipped  nothing was heard\n"
            "can      axis 1                     pass\n");
}

TEST(BringupTable, SkippedChecksOfTwoGroupsStayApart) {
  std::vector<Finding> both;
  for (const char* const group : {"cameras", "gpio"}) {
    Findings findings(group);
    for (const char* const check : {"a", "b"}) findings.skip(check, "why");
    for (Finding& finding : findings.take()) both.push_back(std::move(finding));
  }
  EXPECT_EQ(table_of(both),
            "cameras  a                          skipped  why\n"
            "cameras  b                          skipped  why\n"
            "gpio     a                          skipped  why\n"
            "gpio     b                          skipped  why\n");
}

}  // namespace
}  // namespace vergence::tools
