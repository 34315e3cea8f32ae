/* The elements of an .mbs, as much of XML as it needs; for equations_fit.c.
 *
 * urdf2mbs writes this file anew at each conversion: do not edit it. */
#ifndef EQUATIONS_FIT_ELEMENTS_h
#define EQUATIONS_FIT_ELEMENTS_h

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Text {
    const char *start;
    size_t length;
} Text;

/* Elements are numbered in the order of the file; -1 stands for no element. */
typedef struct Element {
    Text tag, attributes, text;
    int parent, first_child, last_child, next;
} Element;

typedef struct Document {
    char *bytes;
    Element *elements;
    int n_elements;
} Document;

static void *allocate(void *memory, size_t size)
{
    void *larger = realloc(memory, size);

    if (larger == NULL) {
        fprintf(stderr, "error: out of memory\n");
        exit(EXIT_FAILURE);
    }
    return larger;
}

static int is_blank(char letter)
{
    return letter != '\0' && strchr(" \t\r\n", letter) != NULL;
}

static Text strip(const char *start, const char *end)
{
    while (start < end && is_blank(*start)) {
        start++;
    }
    while (start < end && is_blank(end[-1])) {
        end--;
    }
    return (Text) { start, (size_t) (end - start) };
}

/* Return the end of the markup that begins at a '<': after its '>', or the end of the file. */
static const char *end_of_markup(const char *cursor)
{
    const char *closing = NULL;
    char quote = '\0';

    if (strncmp(cursor, "<!--", 4) == 0) {
        closing = "-->";
    } else if (strncmp(cursor, "<?", 2) == 0) {
        closing = "?>";
    }
    if (closing != NULL) {
        const char *end = strstr(cursor, closing);
        return end == NULL ? cursor + strlen(cursor) : end + strlen(closing);
    }
    for (; *cursor != '\0'; cursor++) {
        if (quote != '\0') {
            quote = *cursor == quote ? '\0' : quote;
        } else if (*cursor == '"' || *cursor == '\'') {
            quote = *cursor;
        } else if (*cursor == '>') {
            return cursor + 1;
        }
    }
    return cursor;
}

static int append_element(Document *document, int parent, Text tag, Text attributes, Text text)
{
    int number = document->n_elements++;
    Element *elements;

    if ((number & (number - 1)) == 0) { /* a power of two: double the room */
        size_t room = number == 0 ? 1 : 2 * (size_t) number;
        document->elements = allocate(document->elements, room * sizeof(Element));
    }
    elements = document->elements;
    elements[number] = (Element) { tag, attributes, text, parent, -1, -1, -1 };
    if (parent >= 0) {
        if (elements[parent].first_child < 0) {
            elements[parent].first_child = number;
        } else {
            elements[elements[parent].last_child].next = number;
        }
        elements[parent].last_child = number;
    }
    return number;
}

static void find_elements(Document *document)
{
    int parent = -1;
    const char *cursor = strchr(document->bytes, '<');

    while (cursor != NULL) {
        const char *end = end_of_markup(cursor);
        const char *next = strchr(end, '<');
        int is_tag = cursor[1] != '!' && cursor[1] != '?' && end > cursor + 2;

        if (is_tag && cursor[1] == '/') {
            parent = parent < 0 ? -1 : document->elements[parent].parent;
        } else if (is_tag) {
            int is_empty = end[-2] == '/';
            const char *inner = end - 1 - is_empty, *name = cursor + 1;
            size_t length = strcspn(name, " \t\r\n/>");
            Text attributes = strip(name + length, inner > name + length ? inner : name + length);
            Text text = strip(end, next == NULL ? end : next);
            Text tag = { name, length };
            int number = append_element(document, parent, tag, attributes, text);
            parent = is_empty ? parent : number;
        }
        cursor = next;
    }
}

/* Read a file. Return 0 if it cannot be read, or has no element in an encoding where an ASCII
 * letter is one byte; else 1. */
static int read_document(Document *document, const char *file)
{
    FILE *stream = fopen(file, "rb");
    size_t length = 0, room = 1 << 16;

    *document = (Document) { NULL, NULL, 0 };
    if (stream == NULL) {
        return 0;
    }
    document->bytes = allocate(NULL, room);
    while (1) {
        length += fread(document->bytes + length, 1, room - 1 - length, stream);
        if (length < room - 1) {
            break;
        }
        room *= 2;
        document->bytes = allocate(document->bytes, room);
    }
    fclose(stream);
    document->bytes[length] = '\0';
    find_elements(document);
    return document->n_elements > 0;
}

static int equals(Text text, const char *word)
{
    return strlen(word) == text.length && memcmp(text.start, word, text.length) == 0;
}

static int are_equal(Text first, Text second)
{
    return first.length == second.length && memcmp(first.start, second.start, first.length) == 0;
}

/* Return the first child with a tag; find_next returns the next sibling with a tag. */
static int find_child(const Document *document, int parent, const char *tag)
{
    int child = parent < 0 ? -1 : document->elements[parent].first_child;

    while (child >= 0 && !equals(document->elements[child].tag, tag)) {
        child = document->elements[child].next;
    }
    return child;
}

static int find_next(const Document *document, int element, const char *tag)
{
    do {
        element = document->elements[element].next;
    } while (element >= 0 && !equals(document->elements[element].tag, tag));
    return element;
}

static Text text_of(const Document *document, int element)
{
    return element < 0 ? (Text) { "", 0 } : document->elements[element].text;
}

static double number_of(const Document *document, int element)
{
    Text text = text_of(document, element);

    return text.length == 0 ? 0.0 : strtod(text.start, NULL);
}

static int has_attribute(Text attributes, const char *name)
{
    size_t length = strlen(name);
    const char *cursor = attributes.start, *end = cursor + attributes.length;
    char quote = '\0';

    for (; cursor < end; cursor++) {
        if (quote != '\0') {
            quote = *cursor == quote ? '\0' : quote;
        } else if (*cursor == '"' || *cursor == '\'') {
            quote = *cursor;
        } else {
            int is_start = cursor == attributes.start || strchr(" \t\r\n\"'", cursor[-1]) != NULL;
            int is_name = (size_t) (end - cursor) > length && strncmp(cursor, name, length) == 0;
            if (is_start && is_name && (cursor[length] == '=' || is_blank(cursor[length]))) {
                return 1;
            }
        }
    }
    return 0;
}

#endif
