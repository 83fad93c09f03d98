#include "nanoweft/app/yaml_options.hpp"

#include <yaml.h>

#include <algorithm>
#include <new>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

class Document {
 public:
  explicit Document(yaml_parser_t& parser) : loaded_(yaml_parser_load(&parser, &document_)) {}
  ~Document() {
    if (loaded_) yaml_document_delete(&document_);
  }
  Document(const Document&) = delete;
  Document& operator=(const Document&) = delete;
  bool loaded() const { return loaded_; }
  yaml_node_t* root() { return yaml_document_get_root_node(&document_); }
  yaml_node_t& node(int index) { return *yaml_document_get_node(&document_, index); }

 private:
  yaml_document_t document_;
  bool loaded_;
};

class Parser {
 public:
  explicit Parser(const std::string& text) {
    if (!yaml_parser_initialize(&parser_)) throw std::bad_alloc();
    yaml_parser_set_input_string(&parser_, reinterpret_cast<const unsigned char*>(text.data()),
                                 text.size());
  }
  ~Parser() { yaml_parser_delete(&parser_); }
  Parser(const Parser&) = delete;
  Parser& operator=(const Parser&) = delete;
  yaml_parser_t& get() { return parser_; }

 private:
  yaml_parser_t parser_;
};

/// Gathers the options of one document.
class Gatherer {
 public:
  Gatherer(Document& document, const std::string& where, std::vector<YamlOption>& options)
      : document_(document), where_(where), options_(options) {}

  void map(const yaml_node_t& node, const std::string& prefix, int depth) {
    if (node.type == YAML_SCALAR_NODE && node.data.scalar.length == 0) return;
    if (node.type != YAML_MAPPING_NODE)
      refuse(node, "expected 'name: value' with a blank behind the colon");
    // A map may refer to one that it is part of.
    if (depth > 50) refuse(node, "maps are nested too deeply, or contain themselves");
    const auto& pairs = node.data.mapping.pairs;
    auto merges = [&](const yaml_node_pair_t* pair) {
      const yaml_node_t& key = document_.node(pair->key);
      return key.type == YAML_SCALAR_NODE && scalar(key, "a name") == "<<";
    };
    // What is merged comes first, since of two values the later holds, and a map's own hold.
    for (const bool merged : {true, false})
      for (auto* pair = pairs.start; pair < pairs.top; ++pair)
        if (merges(pair) == merged)
          entry(document_.node(pair->key), document_.node(pair->value), prefix, depth);
  }

 private:
  [[noreturn]] void refuse(const yaml_node_t& node, const std::string& reason) const {
    throw InputError(where_ + format(": line %zu: ", node.start_mark.line + 1) + reason);
  }

  std::string scalar(const yaml_node_t& node, const char* what) const {
    if (node.type != YAML_SCALAR_NODE) refuse(node, std::string(what) + " must be one word");
    std::string text(reinterpret_cast<const char*>(node.data.scalar.value),
                     node.data.scalar.length);
    const bool control = std::ranges::any_of(
        text, [](char c) { return (c >= 0 && c < ' ' && c != '\t') || c == 127; });
    if (control) refuse(node, "a control character, or a value of several lines");
    return text;
  }

  void entry(const yaml_node_t& key, const yaml_node_t& value, const std::string& prefix,
             int depth) {
    const std::string name = scalar(key, "a name");
    if (name == "<<") {
      merge(value, prefix, depth);
      return;
    }
    if (name.starts_with("$$")) {
      if (value.tag && std::string(reinterpret_cast<char*>(value.tag)).ends_with("!include"))
        refuse(value, "!include is not supported; write 'options_file: NAME'");
      return;
    }
    if (name.starts_with("-"))
      refuse(key, format("'%.40s': in YAML options are written without -", name.c_str()));
    if (value.type == YAML_MAPPING_NODE)
      map(value, prefix + name + "_", depth + 1);
    else
      add(key, prefix + name,
          value.type == YAML_SEQUENCE_NODE ? list(value, prefix + name + "_", depth)
                                           : scalar(value, "a value"));
  }

  void merge(const yaml_node_t& value, const std::string& prefix, int depth) {
    // References to references grow without bound.
    if (++merged_ > 100000) refuse(value, "more than 100,000 maps are merged");
    if (value.type != YAML_SEQUENCE_NODE) return map(value, prefix, depth + 1);
    // Of several maps the first holds.
    const auto& items = value.data.sequence.items;
    for (auto* item = items.top; item > items.start; --item)
      map(document_.node(item[-1]), prefix, depth + 1);
  }

  /// An element `name: {option: value}` gives its name to the list and has options of its own.
  std::string list(const yaml_node_t& node, const std::string& prefix, int depth) {
    std::string joined;
    const auto& items = node.data.sequence.items;
    for (auto* item = items.start; item < items.top; ++item) {
      const yaml_node_t& element = document_.node(*item);
      std::string word;
      if (element.type == YAML_MAPPING_NODE) {
        const auto& pairs = element.data.mapping.pairs;
        if (pairs.top - pairs.start != 1) refuse(element, "a map in a list must have one name");
        map(element, prefix, depth + 1);
        word = scalar(document_.node(pairs.start->key), "a name");
      } else {
        word = scalar(element, "an element of a list");
      }
      if (word.find(',') != std::string::npos)
        refuse(element, format("'%.40s': an element of a list cannot hold a comma", word.c_str()));
      joined += (item == items.start ? "" : ",") + word;
    }
    return joined;
  }

  void add(const yaml_node_t& key, std::string name, std::string value) {
    // References to references grow without bound.
    if (options_.size() >= 100000) refuse(key, "more than 100,000 options");
    options_.push_back(
        {static_cast<int>(key.start_mark.line) + 1, std::move(name), std::move(value)});
  }

  Document& document_;
  const std::string& where_;
  std::vector<YamlOption>& options_;
  int merged_ = 0;
};

/// What the parser stumbled over.
std::string complaint(const yaml_parser_t& parser, const std::string& text) {
  std::size_t line = parser.problem_mark.line + 1;
  if (parser.error == YAML_READER_ERROR)
    line = 1 + static_cast<std::size_t>(std::count(
                   text.begin(),
                   text.begin() +
                       static_cast<std::ptrdiff_t>(std::min(parser.problem_offset, text.size())),
                   '\n'));
  return format(": line %zu: %s", line, parser.problem ? parser.problem : "cannot be parsed");
}

}  // namespace

std::vector<YamlOption> parseYaml(const std::string& text, const std::string& where) {
  std::vector<YamlOption> options;
  Parser parser(text);
  while (true) {
    Document document(parser.get());
    if (!document.loaded()) throw InputError(where + complaint(parser.get(), text));
    const yaml_node_t* root = document.root();
    if (!root) return options;
    Gatherer(document, where, options).map(*root, "", 0);
  }
}

}  // namespace nanoweft
