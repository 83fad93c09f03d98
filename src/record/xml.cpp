#include "nanoweft/record/xml.hpp"

#include <cstdint>

namespace nanoweft {

namespace {

constexpr std::uint32_t noCharacter = 0xFFFFFFFF;

/// Takes the UTF-8 character at `at`; what is none takes one byte.
std::uint32_t nextCharacter(const std::string& text, std::size_t& at) {
  const auto byte = [&](std::size_t k) {
    return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u;
  };
  const std::uint32_t first = byte(at++);
  if (first < 0x80) return first;
  const int more = first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : 1;
  if (first < 0xC2 || first > 0xF4) return noCharacter;
  std::uint32_t character = first & (0x3Fu >> more);
  for (int k = 0; k < more; ++k) {
    const std::uint32_t next = byte(at + static_cast<std::size_t>(k));
    if ((next & 0xC0) != 0x80) return noCharacter;
    character = character << 6 | (next & 0x3F);
  }
  const std::uint32_t least[] = {0, 0x80, 0x800, 0x10000};
  const bool surrogate = character >= 0xD800 && character < 0xE000;
  if (character < least[more] || character > 0x10FFFF || surrogate) return noCharacter;
  at += static_cast<std::size_t>(more);
  return character;
}

bool isAllowed(std::uint32_t c) {
  return c >= 0x20 && c != 0x7F && c != 0xFFFE && c != 0xFFFF && c != noCharacter;
}

void replaceAll(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

/// Characters that are not allowed become `?`; line ends stay when wanted.
std::string cleaned(const std::string& text, bool keepLines) {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = at;
    const std::uint32_t c = nextCharacter(text, at);
    if (isAllowed(c) || (keepLines && c == '\n'))
      result += text.substr(begin, at - begin);
    else
      result += '?';
  }
  return result;
}

constexpr const char* commentBegin = "<!--\n";
constexpr const char* commentEnd = "\n-->\n";

}  // namespace

bool isXmlText(const std::string& text) {
  for (std::size_t at = 0; at < text.size();)
    if (!isAllowed(nextCharacter(text, at))) return false;
  return true;
}

std::string printable(const std::string& text) {
  return cleaned(text, false);
}

std::string xmlEscaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&apos;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string xmlComment(const std::string& lines) {
  std::string text = cleaned(lines, true);
  // Two hyphens must not stand in a comment.
  replaceAll(text, "&", "&amp;");
  replaceAll(text, "--", "-&#45;");
  replaceAll(text, "--", "-&#45;");
  return commentBegin + text + commentEnd;
}

std::string xmlCommentIn(const std::string& document) {
  const std::string begin = commentBegin;
  const std::size_t end = document.find(commentEnd);
  if (!document.starts_with(begin) || end == std::string::npos) return "";
  std::string text = document.substr(begin.size(), end - begin.size());
  replaceAll(text, "&#45;", "-");
  replaceAll(text, "&amp;", "&");
  return text;
}

}  // namespace nanoweft
