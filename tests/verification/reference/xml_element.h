#pragma once
// The part of XML that solver files use: elements, attributes, text and comments. Not supported: entities other than
// the five predefined ones, DTDs, namespaces.

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::verification {

struct XmlElement {
    std::string name;
    std::map<std::string, std::string> attributes;
    std::string text; ///< text directly inside the element, without the text of child elements
    std::vector<XmlElement> children;
    int line = 0; ///< line of the start tag, from 1

    /// The only child of this name.
    /// @throws InputError naming the line when there is no such child, or more than one.
    const XmlElement& child(const std::string& wanted) const;
    std::vector<const XmlElement*> all(const std::string& wanted) const;
    /// The value of an attribute.
    /// @throws InputError naming the line when there is no such attribute.
    const std::string& attribute(const std::string& wanted) const;
};

/// Parses a document. @return the root element.
/// @throws InputError naming the line that is not well formed.
XmlElement parse_xml(std::string_view text);

/// The text escaped for an attribute or an element.
std::string xml_escaped(std::string_view text);

} // namespace retractor::verification
