/// The little of XML 1.0 that an index of snapshots needs.
#pragma once

#include <string>

namespace nanoweft {

/// Is this UTF-8 with characters that may stand in one line of an XML document?
bool isXmlText(const std::string& text);

/// The text with escapes, as an attribute's value or an element's text.
std::string xmlEscaped(const std::string& text);

/// A comment that holds these lines, whatever is in them, and the lines of one at the beginning of
/// `document` (empty when there is none).
std::string xmlComment(const std::string& lines);
std::string xmlCommentIn(const std::string& document);

/// For a message in one line: `?` stands for what a terminal should not get.
std::string printable(const std::string& text);

}  // namespace nanoweft
