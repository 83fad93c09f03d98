#include "nanoweft/app/text_input.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "nanoweft/app/signals.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

constexpr std::size_t longestLine = 1 << 20;

/// Waits for bytes or for the end; false: a system error.
bool await(int fd) {
  pollfd wanted{fd, POLLIN, 0};
  while (true) {
    // Signals do not restart poll.
    if (stopRequested()) throw Interrupted("stopped by a signal while options were read");
    if (poll(&wanted, 1, 200) > 0) return true;
    if (errno != EINTR && errno != 0) return false;
    errno = 0;
  }
}

[[noreturn]] void refuse(const std::string& where, const std::string& reason) {
  throw InputError(where + ": " + reason);
}

[[noreturn]] void refuseUnreadable(const std::string& where, const std::string& file, int error) {
  std::string reason = std::string("cannot be read: ") + std::strerror(error);
  if (error == ENOENT && (file.starts_with("/dev/fd/") || file.starts_with("/proc/self/fd/")))
    reason += " (mpirun passes /dev/stdin on to rank 0, but no other pipe)";
  refuse(where, reason);
}

void checkLines(const std::string& text, const std::string& where) {
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
    refuse(where, "is in UTF-16; save it as UTF-8");
  if (text.find('\0') != std::string::npos) refuse(where, "is not a text file (it has NUL bytes)");
  int number = 1;
  for (std::size_t begin = 0; begin < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (end - begin > longestLine) refuse(where, format("line %d is longer than 1 MB", number));
    begin = end + 1;
  }
}

bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

std::string shown(const std::string& word) {
  return word.size() > 40 ? word.substr(0, 40) + "..." : word;
}

/// Words of text[begin, end), until a comment where there may be one.
std::vector<Word> wordsOf(const std::string& text, std::size_t begin, std::size_t end,
                          const std::string& where, bool comments) {
  std::vector<Word> words;
  for (std::size_t at = begin; at < end;) {
    if (isBlank(text[at])) {
      ++at;
      continue;
    }
    if (comments && text[at] == '#') break;
    Word word;
    if (text[at] == '"' || text[at] == '\'') {
      const std::size_t close = text.find(text[at], at + 1);
      if (close >= end)
        refuse(where, format("the quote before '%s' is not closed",
                             shown(text.substr(at + 1, end - at - 1)).c_str()));
      word = {text.substr(at + 1, close - at - 1), true};
      at = close + 1;
      if (at < end && !isBlank(text[at]))
        refuse(where, format("a blank is missing after the quoted '%s'", shown(word.text).c_str()));
    } else {
      const std::size_t start = at;
      while (at < end && !isBlank(text[at])) ++at;
      word.text = text.substr(start, at - start);
    }
    for (const char c : word.text)
      if ((c > 0 && c < ' ' && c != '\t') || c == 127)
        refuse(where, format("a control character (%d) in a word", c));
    words.push_back(std::move(word));
  }
  return words;
}

}  // namespace

TextFile::TextFile(std::string file, std::string where)
    : file_(std::move(file)),
      where_(std::move(where)),
      // Without O_NONBLOCK a pipe that nobody writes to could not be given up.
      descriptor_(open(file_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)) {
  // A socket cannot be opened by its name.
  if (descriptor_ < 0 && errno == ENXIO && file_ == "/dev/stdin") descriptor_ = dup(STDIN_FILENO);
  if (descriptor_ < 0) refuseUnreadable(where_, file_, errno);
  struct stat status {};
  const int code = fstat(descriptor_, &status), error = errno;
  if (code == 0 && !S_ISDIR(status.st_mode)) {
    key_ = {status.st_dev, status.st_ino, !S_ISFIFO(status.st_mode) && !S_ISSOCK(status.st_mode)};
    return;
  }
  close(descriptor_);
  if (code != 0) refuseUnreadable(where_, file_, error);
  refuse(where_, "cannot be read: it is a folder");
}

TextFile::~TextFile() {
  close(descriptor_);
}

std::string TextFile::read(std::size_t most) {
  std::string text;
  std::vector<char> block(1 << 16);
  while (true) {
    errno = 0;
    if (!await(descriptor_)) refuseUnreadable(where_, file_, errno);
    const ssize_t count = ::read(descriptor_, block.data(), block.size());
    if (count == 0) break;
    if (count < 0) {
      if (errno == EAGAIN || errno == EINTR) continue;
      refuseUnreadable(where_, file_, errno);
    }
    text.append(block.data(), static_cast<std::size_t>(count));
    if (text.size() > most)
      refuse(where_, format("is larger than %zu MB, which no file of options is", most >> 20));
    if (text.find('\0', text.size() - static_cast<std::size_t>(count)) != std::string::npos) break;
  }
  checkLines(text, where_);
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  return text;
}

std::vector<TextLine> splitLines(const std::string& text, const std::string& where) {
  std::vector<TextLine> lines;
  int number = 1;
  for (std::size_t begin = 0; begin < text.size(); ++number) {
    const std::size_t end = std::min(text.find_first_of("\r\n", begin), text.size());
    auto words = wordsOf(text, begin, end, where + format(": line %d", number), true);
    if (!words.empty()) lines.push_back({number, std::move(words)});
    begin = end + (text.compare(end, 2, "\r\n") == 0 ? 2 : 1);
  }
  return lines;
}

std::vector<Word> splitWords(const std::string& text, const std::string& where) {
  return wordsOf(text, 0, text.size(), where, false);
}

bool isOptionName(const std::string& word) {
  const std::size_t first = word.starts_with("--") ? 2 : 1;
  if (word.size() <= first || word[0] != '-') return false;
  if (!std::isalpha(static_cast<unsigned char>(word[first]))) return false;
  char* end = nullptr;
  std::strtod(word.c_str() + first - 1, &end);
  return end == word.c_str() + first - 1 || *end == '_' ||
         std::isalnum(static_cast<unsigned char>(*end));
}

}  // namespace nanoweft
