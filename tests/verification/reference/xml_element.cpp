#include "tests/verification/reference/xml_element.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <utility>

namespace retractor::verification {

namespace {

    constexpr std::array<std::pair<std::string_view, char>, 5> kEntities { { { "&amp;", '&' }, { "&lt;", '<' },
        { "&gt;", '>' }, { "&quot;", '"' }, { "&apos;", '\'' } } };

    bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
    bool ends_name(char c) { return is_blank(c) || c == '=' || c == '/' || c == '>' || c == '<'; }

    class Parser {
    public:
        explicit Parser(std::string_view text)
            : text_(text)
        {
        }

        XmlElement document()
        {
            skip_between();
            XmlElement root = element(0);
            skip_between();
            if (at_ < text_.size())
                fail("there is text after the root element");
            return root;
        }

    private:
        [[noreturn]] void fail(const std::string& what) const
        {
            throw InputError("not well-formed XML: " + what, "line " + std::to_string(line_));
        }

        bool starts(std::string_view with) const { return text_.substr(at_).starts_with(with); }

        void advance(std::size_t count)
        {
            const std::size_t end = std::min(at_ + count, text_.size());
            line_ += static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                text_.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
            at_ = end;
        }

        void skip_past(std::string_view mark)
        {
            const std::size_t found = text_.find(mark, at_);
            if (found == std::string_view::npos)
                fail("\"" + std::string(mark) + "\" is missing");
            advance(found + mark.size() - at_);
        }

        void skip_blanks()
        {
            while (at_ < text_.size() && is_blank(text_[at_]))
                advance(1);
        }

        /// Skips blanks, comments and declarations outside the root.
        void skip_between()
        {
            for (skip_blanks(); starts("<?") || starts("<!--"); skip_blanks())
                skip_past(starts("<?") ? "?>" : "-->");
        }

        std::string name()
        {
            const std::size_t begin = at_;
            while (at_ < text_.size() && !ends_name(text_[at_]))
                ++at_;
            if (at_ == begin)
                fail("a name is missing");
            return std::string(text_.substr(begin, at_ - begin));
        }

        void expect(char c)
        {
            if (at_ >= text_.size() || text_[at_] != c)
                fail(std::string("'") + c + "' is missing");
            ++at_;
        }

        /// The text up to `end`, with entities replaced.
        std::string text_until(char end)
        {
            const std::size_t found = text_.find(end, at_);
            if (found == std::string_view::npos)
                fail(std::string("'") + end + "' is missing");
            const std::string_view raw = text_.substr(at_, found - at_);
            std::string plain;
            plain.reserve(raw.size());
            for (std::size_t i = 0; i < raw.size();) {
                if (raw[i] != '&') {
                    plain += raw[i++];
                    continue;
                }
                const auto* entity = std::find_if(kEntities.begin(), kEntities.end(),
                    [&](const auto& known) { return raw.substr(i).starts_with(known.first); });
                if (entity == kEntities.end())
                    fail("an unknown entity");
                plain += entity->second;
                i += entity->first.size();
            }
            advance(raw.size());
            return plain;
        }

        void attributes(XmlElement& element)
        {
            for (skip_blanks(); at_ < text_.size() && text_[at_] != '/' && text_[at_] != '>'; skip_blanks()) {
                std::string key = name();
                skip_blanks();
                expect('=');
                skip_blanks();
                const char quote = at_ < text_.size() ? text_[at_] : '\0';
                if (quote != '"' && quote != '\'')
                    fail("the value of " + key + " has no quotes");
                ++at_;
                if (!element.attributes.emplace(key, text_until(quote)).second)
                    fail("the attribute " + key + " comes twice");
                ++at_;
            }
        }

        XmlElement element(int depth)
        {
            // largest depth of nesting; solver files stay far below, and a malformed file must not exhaust the stack
            constexpr int kDeepest = 100;
            if (depth > kDeepest)
                fail("elements are nested too deeply");
            XmlElement element;
            expect('<');
            element.line = line_;
            element.name = name();
            attributes(element);
            if (starts("/>")) {
                advance(2);
                return element;
            }
            expect('>');
            for (;;) {
                element.text += text_until('<');
                if (starts("<!--")) {
                    skip_past("-->");
                } else if (starts("</")) {
                    advance(2);
                    if (name() != element.name)
                        fail("<" + element.name + "> of line " + std::to_string(element.line) + " is not closed");
                    skip_blanks();
                    expect('>');
                    return element;
                } else {
                    element.children.push_back(this->element(depth + 1));
                }
            }
        }

        std::string_view text_;
        std::size_t at_ = 0;
        int line_ = 1;
    };

    std::string place(const XmlElement& element)
    {
        return "<" + element.name + "> in line " + std::to_string(element.line);
    }

} // namespace

std::vector<const XmlElement*> XmlElement::all(const std::string& wanted) const
{
    std::vector<const XmlElement*> found;
    for (const XmlElement& one : children)
        if (one.name == wanted)
            found.push_back(&one);
    return found;
}

const XmlElement& XmlElement::child(const std::string& wanted) const
{
    const auto found = all(wanted);
    if (found.size() != 1)
        throw InputError(
            "there must be one <" + wanted + "> here, and there are " + std::to_string(found.size()), place(*this));
    return *found.front();
}

const std::string& XmlElement::attribute(const std::string& wanted) const
{
    const auto found = attributes.find(wanted);
    if (found == attributes.end())
        throw InputError("the attribute " + wanted + " is missing", place(*this));
    return found->second;
}

XmlElement parse_xml(std::string_view text) { return Parser(text).document(); }

} // namespace retractor::verification
