"""XML that cannot grow or reach out."""

from xml.etree.ElementTree import Element, ParseError

from caricli.errors import InputError, shown


def parse_xml(data: bytes, kind: str, advice: str = "") -> Element:
    """The root of XML without entities and references to other files, in whatever encoding.

    kind: what is expected. advice: what is said besides where there are such. Raises InputError.
    """
    from defusedxml.common import DefusedXmlException
    from defusedxml.ElementTree import fromstring

    try:
        return fromstring(data)
    except DefusedXmlException:
        raise InputError(f"expected {kind}, found entities or references to other files{advice}") from None
    except (ParseError, ValueError, LookupError) as error:
        raise InputError(f"expected {kind}, found {shown(error, 80)}") from None
