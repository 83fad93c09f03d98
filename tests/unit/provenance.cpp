/// What options say of a run: one text for each value, what is listed, and what a restart may be
/// given.
#include <gtest/gtest.h>

#include <cstdlib>

#include "nanoweft/base/canonical.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/base/options.hpp"

namespace nanoweft {
namespace {

/// Options as a user would give them, taken back at the end.
class Given {
 public:
  explicit Given(std::vector<std::pair<std::string, std::string>> options)
      : options_(std::move(options)) {
    for (const auto& [name, value] : options_)
      petsc(PetscOptionsSetValue(nullptr, ("-" + name).c_str(), value.c_str()));
  }
  ~Given() {
    for (const auto& option : options_)
      PetscOptionsClearValue(nullptr, ("-" + option.first).c_str());
  }
  Given(const Given&) = delete;
  Given& operator=(const Given&) = delete;

 private:
  std::vector<std::pair<std::string, std::string>> options_;
};

/// One option of each kind; `on` is switched on by being given.
void readAll(Options& options) {
  OptionSection s(options, "Kinds");
  s.flag("t_flag", false, "");
  s.real("t_real", 0.5, "", "");
  s.integer("t_whole", 20, "", 0, 100000000);
  s.choice("t_choice", "x", {"x", "y"}, "");
  s.maybeReal("t_maybe", "2 T", "", "");
  s.maybeInteger("t_count", "as -t_whole", "", 0, 1000);
  s.reals("t_list", 2, "20,20", "", "");
  s.reals("t_free", 3, "of the scene", "", "");
  s.flags3("t_sides", "0,0,0", "");
  s.words("t_words", "");
  s.text("t_text", "plain", "");
  s.given("t_on");
  s.real("t_on", 0.3, "", "");
  s.integer("seed", 1, "", 0, 1000);
  s.as(Role::step).maybeReal("t_step", "20", "", "");
  s.as(Role::run).integer("t_end", 100, "", 0, 1000000);
  OptionSection(options, "Other", false, "it is off").real("t_off", 1.0, "", "");
}

std::string listed(const std::vector<std::pair<std::string, std::string>>& given) {
  const Given set(given);
  Options options;
  readAll(options);
  return options.resultOptions({"seed"});
}

/// What a restart of a run with `recorded` says when it is given an option: a problem, or what is
/// listed.
std::string inRestart(const std::string& recorded,
                      const std::vector<std::pair<std::string, std::string>>& given) {
  const Given set(given);
  Options options;
  try {
    options.goOnFrom("c.h5", recorded, {{"t_step", "20"}});
    readAll(options);
    options.refuseUnknown();
    return options.resultOptions({"seed"});
  } catch (const InputError& problem) {
    return problem.what();
  }
}

TEST(Provenance, NumbersAreWrittenShortAndReadBack) {
  const std::pair<double, const char*> numbers[] = {{0.4, "0.4"},
                                                    {-0.0, "0"},
                                                    {2e-7, "2e-7"},
                                                    {0.000001, "1e-6"},
                                                    {1000000.0, "1e6"},
                                                    {100.0, "100"},
                                                    {0.1 + 0.2, "0.30000000000000004"},
                                                    {1e300, "1e300"},
                                                    {5e-324, "5e-324"}};
  for (const auto& [value, text] : numbers) {
    EXPECT_EQ(canonical(value), text);
    EXPECT_EQ(std::strtod(text, nullptr), value);
  }
  double x = 1.0 / 3.0;
  for (int k = 0; k < 200; ++k, x *= -7.123)
    EXPECT_EQ(std::strtod(canonical(x).c_str(), nullptr), x);
}

TEST(Provenance, ListsWhatDiffersFromItsDefaultAndTheSeed) {
  EXPECT_EQ(listed({}), "-seed 1\n");
  EXPECT_EQ(listed({{"t_real", "0.7"}, {"t_flag", ""}, {"seed", "9"}, {"t_choice", "y"}}),
            "-seed 9\n-t_choice y\n-t_flag true\n-t_real 0.7\n");
  EXPECT_EQ(listed({{"t_maybe", "0.000001"}, {"t_count", "1e2"}, {"t_words", "b,a"}}),
            "-seed 1\n-t_count 100\n-t_maybe 1e-6\n-t_words b,a\n");
  EXPECT_EQ(listed({{"t_list", "20,21.0"}, {"t_free", "1,2,1e-3"}, {"t_sides", "yes,0,off"}}),
            "-seed 1\n-t_free 1,2,0.001\n-t_list 20,21\n-t_sides 1,0,0\n");
}

TEST(Provenance, AnOptionGivenWithItsDefaultIsNotListed) {
  EXPECT_EQ(listed({{"t_real", "5e-1"}, {"t_flag", "no"}, {"t_whole", "2e1"}, {"t_choice", "x"}}),
            "-seed 1\n");
  EXPECT_EQ(listed({{"t_list", "2e1,20.0"}, {"t_sides", "0,false,no"}, {"t_text", "plain"}}),
            "-seed 1\n");
}

TEST(Provenance, AnOptionThatSwitchesSomethingOnIsListedWhateverItsValue) {
  EXPECT_EQ(listed({{"t_on", "0.3"}}), "-seed 1\n-t_on 0.3\n");
}

TEST(Provenance, EndsAndOutputsAreNotListedButTheStepIs) {
  EXPECT_EQ(listed({{"t_end", "7"}, {"t_step", "15"}}), "-seed 1\n-t_step 15\n");
}

TEST(RestartOptions, ThoseOfTheCheckpointAreInForce) {
  Options options;
  options.goOnFrom("c.h5", "-seed 4\n-t_free 1,2,3\n-t_on 0.3\n-t_real 0.7\n", {});
  OptionSection s(options, "Kinds");
  EXPECT_EQ(s.real("t_real", 0.5, "", ""), 0.7);
  EXPECT_EQ(s.integer("seed", 1, "", 0, 100), 4);
  EXPECT_EQ(s.reals("t_free", 3, "of the scene", "", ""), (std::vector<double>{1, 2, 3}));
  EXPECT_TRUE(s.given("t_on"));
  EXPECT_EQ(s.real("t_whole", 20, "", ""), 20);
  const auto& reading = options.readings().at("t_real");
  EXPECT_FALSE(reading.byUser);
  EXPECT_EQ(reading.value, "0.7");
  EXPECT_EQ(reading.fallback, "0.5");
}

const std::string all =
    "-seed 1\n-t_choice y\n-t_flag true\n-t_free 1,2,3\n-t_list 5,6\n-t_maybe 1e-6\n-t_on 0.3\n"
    "-t_real 0.7\n-t_sides 1,0,1\n-t_text rough\n-t_whole 1000000\n-t_words a,b\n";

TEST(RestartOptions, TheSameValueInAnotherSpellingAgrees) {
  const std::pair<const char*, const char*> same[] = {
      {"t_choice", "y"},       {"t_flag", "on"},   {"t_free", "1.0,2,3e0"}, {"t_list", "5.,06"},
      {"t_maybe", "0.000001"}, {"t_on", "0.30"},   {"t_real", "7e-1"},      {"t_sides", "yes,no,1"},
      {"t_text", "rough"},     {"t_whole", "1e6"}, {"t_words", "a,b"},      {"seed", "1.0"}};
  for (const auto& [name, value] : same) EXPECT_EQ(inRestart(all, {{name, value}}), all) << name;
  // What the checkpoint had by default.
  for (const auto& [name, value] : {std::pair("t_real", "0.50"),
                                    {"t_flag", "off"},
                                    {"t_choice", "x"},
                                    {"t_list", "20,2e1"},
                                    {"t_sides", "0,0,0"}})
    EXPECT_EQ(inRestart("-seed 1\n", {{name, value}}), "-seed 1\n") << name;
}

void expectRefused(const std::string& recorded, const char* name, const char* value,
                   const std::string& was) {
  const std::string said = inRestart(recorded, {{name, value}});
  EXPECT_EQ(said, std::string("-") + name + " " + value + ": the checkpoint c.h5 was made " + was +
                      "; a restart goes on with the same (start a new stage with -scene file "
                      "-scene_file c.h5)");
}

TEST(RestartOptions, AnotherValueIsRefusedWithBothValues) {
  expectRefused(all, "t_choice", "x", "with y");
  expectRefused(all, "t_flag", "no", "with true");
  expectRefused(all, "t_free", "1,2,4", "with 1,2,3");
  expectRefused(all, "t_list", "20,20", "with 5,6");
  expectRefused(all, "t_maybe", "2e-6", "with 1e-6");
  expectRefused(all, "t_on", "0.4", "with 0.3");
  expectRefused(all, "t_real", "0.5", "with 0.7");
  expectRefused(all, "t_sides", "0,0,0", "with 1,0,1");
  expectRefused(all, "t_text", "plain", "with rough");
  expectRefused(all, "t_whole", "1000001", "with 1000000");
  expectRefused(all, "t_words", "b,a", "with a,b");
  expectRefused(all, "seed", "2", "with 1");
}

TEST(RestartOptions, AValueWhereTheCheckpointHadTheDefaultIsRefused) {
  expectRefused("", "t_real", "0.6", "with its default, 0.5");
  expectRefused("", "t_maybe", "3", "with its default, 2 T");
  expectRefused("", "t_choice", "y", "with its default, x");
  expectRefused("", "t_list", "20,21", "with its default, 20,20");
  expectRefused("", "t_free", "1,2,3", "with its default, of the scene");
  expectRefused("", "t_words", "a", "without it");
  expectRefused("", "t_off", "2", "without it");
  expectRefused("-seed 3\n", "seed", "1", "with 3");
}

TEST(RestartOptions, EndsMayChangeAndAStepIsListedWhenItDoes) {
  EXPECT_EQ(inRestart("-seed 1\n", {{"t_end", "5"}}), "-seed 1\n");
  EXPECT_EQ(inRestart("-seed 1\n", {{"t_step", "15"}}), "-seed 1\n-t_step 15\n");
  EXPECT_EQ(inRestart("-seed 1\n-t_step 10\n", {{"t_step", "15"}}), "-seed 1\n-t_step 15\n");
  EXPECT_EQ(inRestart("-seed 1\n-t_step 10\n", {}), "-seed 1\n-t_step 10\n");
  EXPECT_EQ(inRestart("-seed 1\n", {{"t_step", "2e1"}}), "-seed 1\n");
}

TEST(RestartOptions, RecordsThatThisProgramDoesNotUnderstandAreRefused) {
  EXPECT_NE(inRestart("-seed 1\n-t_gone 3\n", {})
                .find("made with -t_gone 3, which this nanoweft "
                      "does not know"),
            std::string::npos);
  EXPECT_NE(inRestart("-seed 1\n-t_off 3\n", {}).find("-t_off 3, which is not used: it is off"),
            std::string::npos);
  for (const char* broken : {"seed 1\n", "-seed\n", "-\n", "- 1\n", "\n", "-seed \n"})
    EXPECT_NE(inRestart(broken, {}).find("is no option"), std::string::npos) << broken;
}

}  // namespace
}  // namespace nanoweft
