#pragma once
// The small part of XML that solver files use: elements, attributes, text, comments. No entities but the five that
// every XML has, no DTD, no namespaces.

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::verification {

struct XmlElement {
    std::string name;
    std::map<std::string, std::string> attributes;
    std::string text; ///< all text directly inside, without what lies in child elements
    std::vector<XmlElement> children;
    int line = 0; ///< where it begins, from 1

    /// The only child of this name. @throws InputError naming the line when there is none, or more than one.
    const XmlElement& child(const std::string& wanted) const;
    std::vector<const XmlElement*> all(const std::string& wanted) const;
    /// @throws InputError naming the line when there is none.
    const std::string& attribute(const std::string& wanted) const;
};

/// The root element. @throws InputError naming the line of what is not well formed.
XmlElement parse_xml(std::string_view text);

} // namespace retractor::verification
