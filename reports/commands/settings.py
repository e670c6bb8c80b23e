"""plumbob settings: settings to paste into your own model, or how a file differs from them."""

from __future__ import annotations

import argparse
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import (
    FileChecks,
    SettingsForContacts,
    SettingsToPaste,
    WantedContact,
    WantedProperty,
)
from plumbob.engines.method import time_step
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.reports.commands.arguments import values

DEFAULT_METHOD = "mujoco/euler+coulomb"  # method with which a file is compared by default
FOR = "for"  # word in place of a method: settings for a wanted property of a contact
WANTED: tuple[WantedProperty, ...] = ("restitution", "penetration", "creep")
IMPACT_SPEED = 1.0  # [m/s] default speed of an impact
FRICTION = 0.3  # default coefficient of friction
# Options that settings for a wanted property do not have
METHOD_OPTIONS = ("stiffness", "friction", "check")
PROPERTY_OPTIONS = ("file", *WANTED, "speed", "mass", "load", "pair")


def command(chosen: argparse.Namespace) -> int:
    """Prints the settings of a method to paste into a model, or how a file differs from them.
    Returns 1 if contacts of the file do not fit its time step."""
    if chosen.method == FOR:
        return _show_contact_settings(chosen)
    for name in PROPERTY_OPTIONS:
        if getattr(chosen, name) is not None:
            raise ParameterError(name, getattr(chosen, name), "given after `settings for`")
    if chosen.check is not None:
        return _check_file(chosen)
    if chosen.method is None:
        raise ParameterError("METHOD", None, "given, as `plumbob settings METHOD --step DT`")
    if chosen.step is None:
        raise ParameterError("step", None, "given, in seconds: settings are for one step")
    method = find_method(chosen.method)
    step = time_step("step", chosen.step)
    writer = engine_of(method).ability(SettingsToPaste)
    if writer is None or method.control != "step":
        raise ParameterError("method", method.name, "one of an engine with settings to paste")
    settings = writer.write(method, step, chosen.stiffness, chosen.friction or FRICTION)
    values.show(chosen, settings, "settings", settings=settings)
    return 0


def _show_contact_settings(chosen: argparse.Namespace) -> int:
    """Prints the settings that give a contact the wanted restitution, penetration or creep."""
    for name in METHOD_OPTIONS:
        if getattr(chosen, name) is not None:
            raise ParameterError(name, getattr(chosen, name), "left out after `settings for`")
    names = [name for name in WANTED if getattr(chosen, name) is not None]
    if len(names) != 1:
        given = ", ".join(names) or None
        raise ParameterError("for", given, f"one of --{', --'.join(WANTED)}")
    if chosen.speed is not None and names[0] != "restitution":
        raise ParameterError("speed", chosen.speed, "left out without --restitution")
    for name in ("mass", "load"):
        if getattr(chosen, name) is not None and names[0] == "restitution":
            raise ParameterError(name, getattr(chosen, name), "left out with --restitution")
    if chosen.pair is not None and chosen.file is None:
        raise ParameterError("pair", " ".join(chosen.pair), "given with a file")
    wanted = WantedContact(
        name=names[0],
        value=getattr(chosen, names[0]),
        step=chosen.step,
        speed=IMPACT_SPEED if chosen.speed is None else chosen.speed,
        mass=chosen.mass,
        load=chosen.load,
        file=None if chosen.file is None else Path(chosen.file),
        pair=None if chosen.pair is None else tuple(chosen.pair),
    )
    engine = engine_of(find_method(DEFAULT_METHOD))
    finder = engine.ability(SettingsForContacts)
    if finder is None or not installed(engine):
        raise ParameterError("for", names[0], f"asked with {engine.name} installed")
    contact_settings = finder.find(wanted)
    values.show(chosen, contact_settings, "contact_settings", settings=contact_settings)
    return 0


def _check_file(chosen: argparse.Namespace) -> int:
    """Prints how the file --check differs from the settings of a method. Returns 1 if the contacts
    of the file do not fit its time step."""
    for name in ("step", "stiffness", "friction"):
        value = getattr(chosen, name)
        if value is not None:
            raise ParameterError(name, value, "left out: --check takes the file's")
    method = find_method(chosen.method or DEFAULT_METHOD)
    engine = engine_of(method)
    checker = engine.ability(FileChecks)
    if checker is None or not installed(engine):
        raise ParameterError(
            "method", method.name, "one of an installed engine that reads MJCF"
        )
    checked = checker.check(Path(chosen.check), method)
    width = max((len(field) for field, _, _ in checked.differences), default=0)
    values.show(chosen, checked, "check", file=chosen.check, checked=checked, width=width)
    return 1 if checked.warnings else 0
