"""Constants for the window, files, messages, handles with a special meaning, and flags of handles."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from .counting import counted

INTERFACE: Mapping[str, int] = MappingProxyType(
    {
        **counted(
            "handle",
            "world=-1 all=-2 all_except_explicit=-3 self=-4 mainscript=-5 main_script=-5 tree=-6 chain=-7 single=-8 "
            "default=-9 all_except_self=-10 parent=-11 scene=-12 app=-13 inverse=-14 appstorage=-15 sceneobject=-16 "
            "sandbox=-17 mesh=-18",
        ),
        **counted(
            "handleflag",
            "assembly=0x400000 togglevisibility=0x400000 extended=0x400000 greyscale=0x400000 codedstring=0x400000 "
            "wxyzquat=0x1000000 reljointbaseframe=0x400000 addmultiple=0x1000000 "
            "setmultiple=0x400000 abscoords=0x800000 depthbuffer=0x800000 depthbuffermeters=0x800000 "
            "keeporiginal=0x400000 camera=0x400000 altname=0x400000 axis=0x400000 resetforce=0x400000 "
            "resettorque=0x800000 resetforcetorque=0xc00000 model=0x800000 rawvalue=0x1000000 silenterror=0x2000000",
        ),
        **counted(
            "objectproperty",
            "ignoreviewfitting=1 collapsed=0x10 selectable=0x20 selectmodelbaseinstead=0x80 "
            "dontshowasinsidemodel=0x100 canupdatedna=0x400 selectinvisible=0x800 depthinvisible=0x1000 "
            "cannotdelete=0x2000 cannotdeleteduringsim=0x4000 hierarchyhiddenmodelchild=0x8000 "
            "hiddenforsimulation=0x10000",
        ),
        **counted("filedlg", "type_load type_save type_load_multiple type_folder"),
        **counted("msgbox", "type_info type_question type_warning type_critical"),
        **counted("msgbox", "buttons_ok buttons_yesno buttons_yesnocancel buttons_okcancel"),
        **counted("msgbox", "return_cancel return_no return_yes return_ok return_error"),
        **counted("dlgstyle", "message input ok ok_cancel yes_no dont_center=32"),
        **counted("dlgret", "still_open ok cancel yes no"),
        **counted(
            "message",
            "ui_button_state_change - object_selection_changed - model_loaded - keypress bannerclicked scene_loaded "
            "prox_sensor_select_down prox_sensor_select_up pick_select_down",
        ),
        **counted(
            "message",
            "simulation_start_resume_request simulation_pause_request simulation_stop_request",
            0x1000,
        ),
        **counted(
            "navigation",
            "passive camerashift camerarotate camerazoom cameratilt cameraangle camerafly objectshift objectrotate "
            "createpathpoint=0x100 clickselection=0x200 ctrlselection=0x400 shiftselection=0x800 "
            "camerazoomwheel=0x1000 camerarotaterightbutton=0x2000 camerarotatemiddlebutton=0x2000",
        ),
        **counted(
            "banner",
            "left=1 right=2 nobackground=4 overlay=8 followparentvisibility=0x10 clickselectsparent=0x20 "
            "clicktriggersevent=0x40 facingcamera=0x80 fullyfacingcamera=0x100 backfaceculling=0x200 "
            "keepsamesize=0x400 bitmapfont=0x800",
        ),
        **counted(
            "gui",
            "menubar=1 popups=2 toolbar1=4 toolbar2=8 hierarchy=0x10 infobar=0x20 statusbar=0x40 scripteditor=0x80 "
            "scriptsimulationparameters=0x100 dialogs=0x200 browser=0x400 splash=0x800 all=0xffff headless=0x10000",
        ),
        **counted(
            "displayattribute",
            "renderpass=1 depthpass=2 pickpass=4 selected=8 groupselection=0x10 mainselection=0x20 forcewireframe=0x40 "
            "forbidwireframe=0x80 forbidedges=0x100 originalcolors=0x200 ignorelayer=0x400 forvisionsensor=0x800 "
            "colorcodedpickpass=0x1000 colorcoded=0x2000 trianglewireframe=0x4000 inertiaonly=0x8000 "
            "thickEdges=0x10000 dynamiccontentonly=0x20000 mirror=0x40000 useauxcomponent=0x80000 "
            "ignorerenderableflag=0x100000 noopenglcallbacks=0x200000 noghosts=0x800000 nopointclouds=0x1000000 "
            "nodrawingobjects=0x2000000 noparticles=0x4000000 colorcodedtriangles=0x8000000",
        ),
        **counted(
            "ui",
            "property_visible=1 property_visibleduringsimulationonly=2 property_moveable=4 "
            "property_relativetoleftborder=8 property_relativetotopborder=0x10 property_fixedwidthfont=0x20 "
            "property_systemblock=0x40 property_settocenter=0x80 property_rolledup=0x100 "
            "property_selectassociatedobject=0x200 property_visiblewhenobjectselected=0x400 "
            "property_systemblockcanmovetofront=0x800 property_pauseactive=0x1000 menu_title=1 menu_minimize=2 "
            "menu_close=4 menu_systemblock=8",
        ),
        **counted("lock", "ui_wants_to_read ui_wants_to_write nonui_wants_to_write"),
        **counted(
            "verbosity",
            "useglobal=-1 none=100 errors=200 warnings=300 loadinfos=400 default=400 questions=410 scripterrors=420 "
            "scriptwarnings=430 scriptinfos=450 msgs=450 infos=500 debug=600 trace=700 tracelua=800 traceall=900 "
            "undecorated=0xf000 onlyterminal=0x10000 once=0x20000",
        ),
        **counted("platform", "windows macos linux"),
        **counted("headlessmode", "disabled emulated enabled"),
        **counted(
            "script",
            "no_error main_script_nonexistent main_script_not_called reentrance_error=4 lua_error=8 "
            "call_error=16",
        ),
        **counted("simulation", "running=17 lastbeforestop=22"),
        **counted(
            "syscb",
            "beforeinstanceswitch afterinstanceswitch beforecopy aftercopy aos_run aos_suspend aos_resume "
            "jointcallback contactcallback customcallback1 customcallback2 customcallback3 customcallback4 "
            "beforedelete afterdelete aftercreate threadmain dyncallback beforemainscript vision trigger userconfig "
            "moduleentry event ext realtimeidle beforesave aftersave msg dyn contact joint thread selchange data "
            "afterload",
            10,
        ),
        **counted("callbackid", "rossubscriber dynstep userdefined=1000", 1),
        **counted("api", "error_report=1 error_output=2 warning_output=4"),
    }
)
