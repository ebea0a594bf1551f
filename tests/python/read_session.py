"""Reads a Dorsum session with nothing but the public packages `mcap` and `mcap-protobuf-support`; prints it as JSON.

usage: python read_session.py FILE.mcap
"""

import json
import sys

from google.protobuf.descriptor import FieldDescriptor
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


def plain(message):
    """The message as a dict; enums by name, all fields present or absent as in the file."""
    values = {}
    for field, value in message.ListFields():
        if field.type == FieldDescriptor.TYPE_MESSAGE:
            value = plain(value)
        elif field.type == FieldDescriptor.TYPE_ENUM:
            value = field.enum_type.values_by_number[value].name
        values[field.name] = value
    return values


def main(path):
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        session = {"profile": reader.get_header().profile, "fingers": [[], [], [], []], "events": []}
        for record in reader.iter_metadata():
            session["metadata"] = record.metadata
        for attachment in reader.iter_attachments():
            session["scenario"] = attachment.data.decode()
        for _schema, channel, _message, decoded in reader.iter_decoded_messages():
            if channel.topic == "/events":
                session["events"].append(plain(decoded))
            else:
                session["fingers"][int(channel.topic.rsplit("/", 1)[1])].append(plain(decoded))
    json.dump(session, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1])
