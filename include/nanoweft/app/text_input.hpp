/// Files of options as bytes, and their words.
#pragma once

#include <string>
#include <vector>

namespace nanoweft {

/// What a path names, to tell whether two paths name the same file.
struct FileKey {
  unsigned long device = 0, inode = 0;
  bool again = false;  ///< can be read a second time
  bool operator==(const FileKey& other) const {
    return device == other.device && inode == other.inode;
  }
};

/// A file, pipe or terminal that is read once and wholly. Throws InputError (`where`: what the
/// message begins with) when it cannot be.
class TextFile {
 public:
  TextFile(std::string file, std::string where);
  ~TextFile();
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;

  const FileKey& key() const { return key_; }
  /// Throws InputError when it is no text, is larger than `most` bytes or has a line longer than
  /// 1 MB; throws Interrupted when a signal asks to stop while a pipe keeps it waiting.
  std::string read(std::size_t most);

 private:
  std::string file_, where_;
  int descriptor_;
  FileKey key_;
};

struct Word {
  std::string text;
  bool quoted = false;  ///< stood in '' or "", so it is no option's name
};
/// The words of a line, and its number in the text.
struct TextLine {
  int number;
  std::vector<Word> words;
};

/// The words of each line that has any. A word in '' or "" keeps its blanks; # begins a comment at
/// the start of a word. Throws InputError.
std::vector<TextLine> splitLines(const std::string& text, const std::string& where);

/// All words of a text that has no comments, such as an environment variable.
std::vector<Word> splitWords(const std::string& text, const std::string& where);

/// Does PETSc take this for the name of an option? (-5, -inf and -1,-2 are values.)
bool isOptionName(const std::string& word);

}  // namespace nanoweft
