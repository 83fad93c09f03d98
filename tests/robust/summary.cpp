/// What the summary says about damping where people measure forces.
#include <gtest/gtest.h>

#include <cstdlib>

#include "support/program.hpp"

using namespace nanoweft::test;

namespace {

[[maybe_unused]] const int noSleep = setenv("OMPI_MCA_odls_base_sigkill_timeout", "0", 0);

const std::string pulled =
    "-scene weave -weave_fibres 3,3 -weave_segments 24 -tension_rate 1e-6 -tension_grip 30 "
    "-ts_max_steps 600 -progress_interval 0 ";

/// The number behind `words`.
double numberAfter(const std::string& text, const std::string& words) {
  const auto at = text.find(words);
  return at == std::string::npos ? -1e300 : std::atof(text.c_str() + at + words.size());
}

class SummaryOnRanks : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Summary, SummaryOnRanks, testing::Values(1, 3));

TEST_P(SummaryOnRanks, SaysWhatShareOfTheWorkDampingTook) {
  const Folder folder;
  const Outcome outcome = run(folder, pulled + "-damping_local 0.3", GetParam());
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const double damped = numberAfter(outcome.output, "(damped "),
               work = numberAfter(outcome.output, ", external ");
  ASSERT_GT(work, 0.0) << outcome.output;
  const double share = 100 * damped / work;
  EXPECT_NEAR(numberAfter(outcome.output, "damping took "), share, 0.01 * share) << outcome.output;
  EXPECT_EQ(outcome.output.find("remark: -damping_local 0.3") != std::string::npos, share > 5)
      << outcome.output;
}

TEST(Summary, IsSilentWhereNothingIsDampedOrNoWorkIsDone) {
  const Folder folder;
  for (const std::string& options :
       {pulled, std::string("-scene weave -weave_fibres 3,3 -weave_segments 24 -damping_local 0.3 "
                            "-ts_max_steps 50 -progress_interval 0")}) {
    const Outcome outcome = run(folder, options);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(outcome.output.find("damping took"), std::string::npos) << outcome.output;
  }
}

}  // namespace
