/// Files that one process alone writes: what fails leaves what there was.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "nanoweft/base/locked_file.hpp"
#include "nanoweft/record/xml.hpp"

namespace nanoweft {
namespace {

namespace fs = std::filesystem;

class LockedFiles : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "nanoweft-unit-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string content(const std::string& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }
  fs::path folder_;
};

/// The message of what `work` throws, or nothing.
template <class Work>
std::string failureOf(const Work& work) {
  try {
    work();
    return "";
  } catch (const std::exception& failure) {
    return failure.what();
  }
}

TEST_F(LockedFiles, AppendAfterWhatStays) {
  const std::string name = path("a.csv");
  {
    LockedFile file(name);
    file.replace("head\n");
    file.append("1\n");
    file.append("2\n");
    file.append("3\n");
    file.replace("new head\n", 5, 9);
    file.append("4\n");
    file.sync();
    EXPECT_EQ(file.size(), 15);
  }
  EXPECT_EQ(content(name), "new head\n1\n2\n4\n");
}

TEST_F(LockedFiles, BelongToOneAtATime) {
  const std::string name = path("a.csv");
  auto first = std::make_unique<LockedFile>(name);
  auto another = [&] { return failureOf([&] { LockedFile second(name); }); };
  EXPECT_EQ(another(), "cannot write " + name + ": another run is writing it");
  first->replace("head\n");  // the lock goes with the content
  EXPECT_EQ(another(), "cannot write " + name + ": another run is writing it");
  first.reset();
  EXPECT_EQ(another(), "");
}

TEST_F(LockedFiles, LeaveNoEmptyFileBehind) {
  { LockedFile file(path("a.csv")); }
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(LockedFiles, KeepWhatTheyHadWhenTheDiskIsFull) {
  const std::string name = path("a.csv");
  LockedFile file(name);
  file.replace("head\n");
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit less = before;
  less.rlim_cur = 1000;
  setrlimit(RLIMIT_FSIZE, &less);
  const std::string added = failureOf([&] { file.append(std::string(2000, 'x')); }),
                    replaced = failureOf([&] { file.replace(std::string(2000, 'y')); });
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_NE(added.find("File too large"), std::string::npos) << added;
  EXPECT_NE(replaced.find("File too large"), std::string::npos) << replaced;
  EXPECT_EQ(content(name), "head\n");
  file.append("1\n");
  EXPECT_EQ(content(name), "head\n1\n");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(LockedFiles, AreOneBehindAllTheirNames) {
  const std::string name = path("a");
  EXPECT_TRUE(isSameFile(name, path("sub/../a")));
  EXPECT_FALSE(isSameFile(name, path("b")));
  fs::create_symlink("a", path("link"));
  EXPECT_TRUE(isSameFile(name, path("link")));  // dangling
  std::ofstream(name) << "x";
  fs::create_hard_link(name, path("hard"));
  EXPECT_TRUE(isSameFile(path("link"), path("hard")));
}

TEST(Xml, CommentsHoldAnything) {
  for (const char* text :
       {"# a\n# -x 1\n", "--", "-----", "a-", "-->", "&#45;&amp;", "<!--\n\n-->\n"}) {
    const std::string comment = xmlComment(text);
    EXPECT_EQ(xmlCommentIn(comment + "<rest/>"), std::string(text));
    EXPECT_EQ(comment.find("--", 4), comment.size() - 4) << comment;
  }
}

TEST(Xml, OnlyWhatMayStandInADocumentIsText) {
  for (const char* good : {"", "a b",
                           "gr\xc3\xb6\xc3\x9f"
                           "e",
                           "\xe2\x82\xac", "\xf0\x9f\x98\x80"})
    EXPECT_TRUE(isXmlText(good)) << good;
  for (const char* bad : {"\n", "\x01", "\x7f", "\xff", "\xc3", "\xc0\x80", "\xed\xa0\x80",
                          "\xef\xbf\xbe", "\xf4\x90\x80\x80", "\xe2\x82"})
    EXPECT_FALSE(isXmlText(bad));
}

}  // namespace
}  // namespace nanoweft
